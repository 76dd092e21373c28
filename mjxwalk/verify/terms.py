"""What walkers are worth by weighted terms, once more in float64 numpy."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import FitnessTerms
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify.reference import Reference
from mjxwalk.verify.senses import Torso

WEIGHT = 9.81  # N/kg


class Terms:
    """The terms of walkers' trials so far."""

    def __init__(self, law: FitnessTerms, reference: Reference) -> None:
        """Begins trials.

        Args:
          law: weights of the terms.
          reference: the walkers where they start.
        """
        self._law, self._reference = law, reference
        num, motors = len(reference.qpos), reference.anatomy.motors
        self._strength = np.array([motor.strength for motor in motors])
        self._tilted, self._turned, self._off_speed, self._moved = np.zeros((4, num))
        self._lifted = np.zeros(num)
        self._asked = np.zeros((num, len(motors)))
        self._stood = np.zeros((num, len(reference.anatomy.legs)))
        self._feet = tuple(leg.foot for leg in reference.anatomy.legs)
        model, root = reference.herd.model, reference.anatomy.root
        data = mujoco.MjData(model)
        data.qpos[:] = reference.qpos[0, list(reference.anatomy.joint_coordinate)]
        mujoco.mj_kinematics(model, data)
        floor = lowest(reference, data)
        self._still = np.array([float(data.body(foot).xpos[2]) - floor for foot in self._feet])
        height = float(reference.qpos[0, root.height]) - floor
        self._usual = WEIGHT * float(model.body_subtreemass[0]) * height  # N m

    def count(
        self,
        counted: Bool[np.ndarray, " walker"],
        before: tuple[Any, Any],
        action: Float[np.ndarray, "field walker motor"],
        contact: Bool[np.ndarray, "walker leg"],
    ) -> None:
        """Counts a step.

        Args:
          counted: whose step counts.
          before: coordinates and rates before it.
          action: of the step: torque, target, stiffness and damping.
          contact: which feet touched the ground before it.
        """
        qpos, qvel = before
        dt, root = self._reference.env.timestep, self._reference.anatomy.root
        torso = Torso.of(root, qpos, qvel)
        self._tilted += dt * counted * (1.0 - torso.axes[:, 2, 2])
        if root.yaw is not None:
            self._turned += dt * counted * np.abs(qpos[:, root.yaw])
        if self._law.speed:
            ahead = torso.within(torso.velocity)[:, 0]
            self._off_speed += dt * counted * np.abs(ahead - self._law.speed) / self._law.speed
        higher = self._reference.over_ground(self._reference.places(*self._feet)) - self._still
        share = np.clip(higher / self._law.clear_height, 0.0, 1.0) * ~contact
        self._lifted += dt * counted * share.sum(axis=1)
        self._stood += dt * (contact & counted[:, None])
        asked = (action[0] + action[1]) / self._strength
        self._moved += counted * np.abs(asked - self._asked).sum(axis=1)
        self._asked[counted] = asked[counted]

    def worth(self, tally: Any) -> Float[np.ndarray, " walker"]:
        """Returns the fitness of walkers.

        Args:
          tally: what the rules of their trials have counted.
        """
        law, root, qpos = self._law, self._reference.anatomy.root, self._reference.qpos
        seconds = tally.steps * self._reference.env.timestep
        far = qpos[:, root.forward]
        if law.speed:
            far = np.minimum(far, law.speed * seconds)
        aside = 0.0 * far if root.sideways is None else np.abs(qpos[:, root.sideways])
        return np.sum(
            [
                law.distance * far,
                law.alive * seconds,
                law.drift * aside,
                law.work * tally.work / self._usual,
                law.torque * tally.torque_cost / self._usual,
                law.upright * self._tilted,
                law.heading * self._turned,
                law.tracking * self._off_speed,
                law.clearance * self._lifted,
                law.symmetry * (self._stood.max(axis=1) - self._stood.min(axis=1)),
                law.action_rate * self._moved,
            ],
            axis=0,
        )


def lowest(reference: Reference, data: Any) -> float:
    """Returns the height of the lowest contact point of one walker, m.

    Args:
      reference: whose walker it is.
      data: the `mujoco.MjData` of it.
    """
    lows: list[float] = []
    for point in reference.anatomy.points:
        body = data.body(point.body)
        place = body.xpos + body.xmat.reshape(3, 3) @ np.array(point.offset)
        lows.append(float(place[2]) - point.radius)
    return min(lows)
