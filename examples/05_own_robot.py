"""A robot of one's own: a model, a card, and the checks that say what is wrong with them.

BHR-B2 is given a backpack of 3 kg here; another robot needs its own model file and every entry of docs/cards.md.

python examples/05_own_robot.py
"""

import shutil
import tempfile
from pathlib import Path

import gaitsmith
from gaitsmith.errors import BadInput

BACKPACK = (
    '<body name="backpack" pos="-0.12 0 0.3"><inertial pos="0 0 0" mass="3" diaginertia="0.02 0.02 0.02"/></body>'
)


def main(duration: float = 6.0) -> gaitsmith.Episode:
    shipped = gaitsmith.load_robot("bhr_b2").model_path.parent
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "bhr_b2_backpack"
        shutil.copytree(shipped, folder)
        model, card = folder / "bhr_b2.xml", folder / "card.toml"
        model.write_text(model.read_text().replace('<site name="imu"', BACKPACK + '<site name="imu"'))
        try:
            gaitsmith.load_robot(folder)
        except BadInput as error:
            print(f"refused: {error}")
        renamed = card.read_text().replace('name = "bhr_b2"', 'name = "bhr_b2_backpack"')
        card.write_text(renamed.replace("mass = 39.898", "mass = 42.898"))
        robot = gaitsmith.load_robot(folder)
        print(f"{robot.card.name}: {robot.mass:.1f} kg, {len(robot.joint_names)} joints")
        episode = gaitsmith.run_episode(gaitsmith.Scenario(robot=str(folder), speed=(0.3, 0.0), duration=duration))
    stage = episode.summary.stages[-1]
    low, high = stage.pitch_deg
    print(f"commanded 0.3 m/s: {stage.vx_mean:.3f} m/s, pitch {low:.2f} to {high:.2f} degrees")
    return episode


if __name__ == "__main__":
    main()
