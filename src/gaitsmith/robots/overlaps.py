"""Shapes that lie inside each other at home: they would push the robot apart, so they do not collide."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import mujoco

from gaitsmith.robots.model_file import listed

DEEP = 5e-4  # of the model's extent


def exclude_overlaps(
    spec: mujoco.MjSpec, model: mujoco.MjModel, home: Mapping[str, float], feet: Collection[str], notes: list[str]
) -> bool:
    """Exclude collisions of the pairs of bodies that overlap at home, besides that of the feet; whether there are any.

    Args:
        spec: changed in place.
        model: compiled from it.
        home: joint angles by name; others are at zero or at the limit next to it.
        feet: bodies that carry the soles.
        notes: names the pairs.
    """
    data = mujoco.MjData(model)
    for joint in range(1, model.njnt):
        low, high = model.jnt_range[joint]
        angle = home.get(model.joint(joint).name, min(max(0.0, low), high))
        data.qpos[model.jnt_qposadr[joint]] = angle
    mujoco.mj_fwdPosition(model, data)
    pairs = {
        tuple(sorted(model.geom_bodyid[geom] for geom in contact.geom))
        for contact in data.contact
        if contact.dist < -DEEP * model.stat.extent
    }
    named = [tuple(str(model.body(int(body)).name) for body in pair) for pair in sorted(pairs)]
    apart = [(first, second) for first, second in named if not {first, second} <= set(feet)]
    for first, second in apart:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    if apart:
        notes.append(f"overlap at home, and so do not collide: {listed(' and '.join(pair) for pair in apart)}")
    return bool(apart)
