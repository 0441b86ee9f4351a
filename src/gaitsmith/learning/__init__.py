"""Learning on top of the gait template: a Gymnasium environment, policies as files.

``gymnasium.make("gaitsmith/GaitTemplate-v0", robot="bhr_b2")`` finds it once the package is installed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

if TYPE_CHECKING:
    from gaitsmith.learning.environment import GaitTemplateEnv as GaitTemplateEnv
    from gaitsmith.learning.policy_file import Perceptron as Perceptron
    from gaitsmith.learning.policy_file import write_policy as write_policy

ENVIRONMENT = "gaitsmith/GaitTemplate-v0"

__getattr__, __dir__ = lazily(__name__)


def register() -> None:
    """Make the environment known to Gymnasium, which calls this when it is imported."""
    import gymnasium

    if ENVIRONMENT not in gymnasium.registry:
        gymnasium.register(ENVIRONMENT, entry_point="gaitsmith.learning.environment:GaitTemplateEnv")
