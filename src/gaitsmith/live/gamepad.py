"""A gamepad at the browser, if it has one: its sticks and buttons press the page's own keys."""

from __future__ import annotations

_EVERY = 120  # ms between two looks; a stick that is held presses its key again
_DEAD = 0.5  # of a stick's way in which it presses nothing

SCRIPT = """(() => {
  if (window.gaitsmithGamepad) return;
  const held = {};
  const press = (key, code) => document.documentElement.dispatchEvent(
    new KeyboardEvent("keydown", { key, code: code ?? "Key" + key.toUpperCase(), bubbles: true }));
  const sticks = [[1, "w", "s"], [0, "q", "e"], [2, "a", "d"]];
  const buttons = { 0: [" ", "Space"], 1: ["x"], 2: ["n"], 9: ["r"], 12: ["ArrowUp", "ArrowUp"],
    13: ["ArrowDown", "ArrowDown"], 14: ["ArrowLeft", "ArrowLeft"], 15: ["ArrowRight", "ArrowRight"] };
  window.gaitsmithGamepad = setInterval(() => {
    const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one);
    if (!pad) return;
    for (const [axis, low, high] of sticks) {
      const at = pad.axes[axis] ?? 0;
      if (Math.abs(at) > DEAD) press(at < 0 ? low : high);
    }
    for (const [number, key] of Object.entries(buttons)) {
      const down = pad.buttons[number]?.pressed ?? false;
      if (down && !held[number]) press(...key);
      held[number] = down;
    }
  }, EVERY);
})();""".replace("DEAD", str(_DEAD)).replace("EVERY", str(_EVERY))
"""Left stick: speed forward and sideways. Right stick: turning. Cross: pushes. A pauses, B stops, X is one tick."""
