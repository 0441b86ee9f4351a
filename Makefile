# make demo: walk BHR-B2 through a speed profile.   make test: run the tests.   Both set up .venv first, once.
PYTHON ?= python3
WORKERS ?= 2
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
RUN := runs/$(shell date +%Y%m%d-%H%M%S)

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export OMP_NUM_THREADS := 1

.PHONY: demo test bench lint format lock clean setup

setup: $(READY)

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(None if (3, 11) <= v < (3, 14) else "gaitsmith needs Python 3.11 to 3.13, and $(PYTHON) is %d.%d; name another one: make PYTHON=python3.12" % v)'
	@echo "Setting up $(VENV) (once)"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@touch $@

demo: $(READY)
	@$(BIN)/gaitsmith walk figure5 --out $(RUN)

test: $(READY)
	@$(BIN)/python -m pytest -q -n $(WORKERS)

bench: $(READY)
	@$(BIN)/gaitsmith bench tick
	@$(BIN)/gaitsmith bench push --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench battery --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench battery --set courses --jobs $(WORKERS)
	@$(BIN)/gaitsmith bench push --set courses --jobs $(WORKERS)

lint: $(READY)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy --strict src
	@$(BIN)/lint-imports

format: $(READY)
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

# Needs uv on the path. Names, versions and hashes only: no address may stand in the lock.
lock:
	@uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --fork-strategy fewest \
		--generate-hashes --no-emit-index-url --no-emit-find-links --no-annotate --no-header \
		--quiet --output-file requirements.lock >/dev/null
	@! grep -n '://' requirements.lock

clean:
	@rm -rf $(VENV) build dist .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
