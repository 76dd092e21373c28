"""A body on its ground as a MuJoCo model to look at."""

from typing import Any

import numpy as np

from mjxwalk.envs import LeggedEnv, Terrain, scenery
from mjxwalk.envs._mujoco import compiled, mujoco
from mjxwalk.envs.body_sides import body_sides

# Those of the pages; see watch.css.
COLOURS = {"left": [0.122, 0.4, 0.82, 1.0], "right": [0.824, 0.345, 0.106, 1.0]}
LEAST_RELIEF = 0.001  # m; a height field of no height at all is refused
BASE = 0.3  # m of ground below its lowest point


def build(env: LeggedEnv, ground: Terrain, qpos: Any, size: tuple[int, int]) -> Any:
    """Returns the model.

    Args:
      env: body and ground.
      ground: that the walker walks on.
      qpos: where the walker gets to [frame, coordinate].
      size: of the largest picture, pixels across and down.
    """
    spec = env.spec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = size
    spec.visual.headlight.ambient = [0.35] * 3
    known = env.model.mujoco
    names = [str(known.body(body).name) for body in range(known.nbody)]
    sides = dict(zip(names, body_sides(known, env.anatomy), strict=True))
    for geom in spec.geoms:
        side = sides.get(geom.parent.name)
        if side in COLOURS:
            geom.rgba, geom.material = COLOURS[side], ""
    for geom in list(spec.worldbody.geoms):  # the floor
        spec.delete(geom)
    _paint(spec)
    _add_ground(spec, scenery.around(env, ground, np.asarray(qpos)))
    return compiled(spec)


def joint_positions(env: LeggedEnv, qpos: Any) -> Any:
    """Returns the model's joint positions of coordinates [frame, coordinate]."""
    return np.asarray(qpos)[:, list(env.anatomy.joint_coordinate)]


def _paint(spec: Any) -> None:
    """Adds a sky, and a checkered ground on which motion can be seen."""
    texture, builtin = mujoco.mjtTexture, mujoco.mjtBuiltin
    spec.add_texture(
        name="sky",
        type=texture.mjTEXTURE_SKYBOX,
        builtin=builtin.mjBUILTIN_GRADIENT,
        rgb1=[0.75, 0.83, 0.92],
        rgb2=[0.95, 0.96, 0.98],
        width=64,
        height=64,
    )
    spec.add_texture(
        name="checkers",
        type=texture.mjTEXTURE_2D,
        builtin=builtin.mjBUILTIN_CHECKER,
        rgb1=[0.80, 0.79, 0.75],
        rgb2=[0.68, 0.68, 0.64],
        width=128,
        height=128,
    )
    ground = spec.add_material(name="ground", texrepeat=[2.0, 2.0], texuniform=True)
    ground.textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = "checkers"


def _add_ground(spec: Any, around: scenery.Scenery) -> None:
    ground, wide = around
    rows, middle = ground.heights, ground.y + 0.5 * wide
    if len(rows) == 1:  # the same at all y: a strip with the same heights on both edges
        rows, middle = np.repeat(rows, 2, axis=0), 0.0
    low, relief = float(rows.min()), max(float(np.ptp(rows)), LEAST_RELIEF)
    long = ground.spacing * (rows.shape[1] - 1)
    spec.add_hfield(
        name="ground",
        nrow=rows.shape[0],
        ncol=rows.shape[1],
        size=[0.5 * long, 0.5 * wide, relief, BASE],
        userdata=((rows - low) / relief).ravel().tolist(),
    )
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="ground",
        material="ground",
        pos=[ground.x + 0.5 * long, middle, low],
        contype=0,
        conaffinity=0,
    )
