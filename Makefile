# make demo: both papers' robots walk, and a page shows it.   make test: run the tests.   Both set up .venv first, once.
# make strangers: the tests on public robots (fetches 130 MB of models, once).
PYTHON ?= python3
WORKERS ?= 2
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
TOOLS := $(VENV)/.tools
STRANGERS := $(VENV)/.strangers

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export OMP_NUM_THREADS := 1

.PHONY: demo test docs strangers bench lint format lock clean setup

setup: $(READY)

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(None if (3, 11) <= v < (3, 14) else "gaitsmith needs Python 3.11 to 3.13, and $(PYTHON) is %d.%d; name another one: make PYTHON=python3.12" % v)'
	@echo "Setting up $(VENV) (once)"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@touch $@

# The demo needs the core only; tests, checks and the public robots' models are further locks over the same versions.
$(TOOLS): $(READY) requirements-dev.lock
	@echo "Adding the tools of the tests (once)"
	@$(BIN)/python -m pip install --quiet --require-hashes -r requirements-dev.lock
	@touch $@

$(STRANGERS): $(TOOLS) requirements-strangers.lock
	@echo "Fetching public robots (once)"
	@$(BIN)/python -m pip install --quiet --require-hashes -r requirements-strangers.lock
	@touch $@

demo: $(READY)
	@$(BIN)/gaitsmith demo

test: $(TOOLS)
	@$(BIN)/python -m pytest -q -n $(WORKERS)

docs: $(TOOLS)
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict
	@echo "build/site/index.html"

strangers: $(STRANGERS)
	@$(BIN)/python -m pytest -q -m strangers

bench: $(READY)
	@$(BIN)/gaitsmith bench tick
	@$(BIN)/gaitsmith bench push --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench battery --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench battery --set courses --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench push --set courses --jobs $(WORKERS)

lint: $(TOOLS)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy --strict src
	@$(BIN)/lint-imports

format: $(TOOLS)
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

# Needs uv on the path. Names, versions and hashes only: no address may stand in a lock.
COMPILE = uv pip compile pyproject.toml --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
	--no-emit-index-url --no-emit-find-links --no-annotate --no-header --quiet
lock:
	@$(COMPILE) --extra dev --output-file requirements-dev.lock >/dev/null
	@$(COMPILE) --extra build --constraint requirements-dev.lock --output-file requirements.lock >/dev/null
	@$(COMPILE) --extra strangers --constraint requirements-dev.lock --output-file requirements-strangers.lock >/dev/null
	@! grep -n '://' requirements*.lock

clean:
	@rm -rf $(VENV) build dist .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
