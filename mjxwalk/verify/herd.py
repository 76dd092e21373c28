"""Walkers of one body as so many trees of one model, all of which C MuJoCo moves in a call."""

from typing import Any

import numpy as np
from jaxtyping import Float, Int

from mjxwalk.envs._mujoco import compiled, mujoco


class Herd:
    """Where walkers are and how they move, by C MuJoCo in float64; none feels another.

    Attributes:
      model: the `mujoco.MjModel` of one of them.
      data: the `mujoco.MjData` of all.
      num: of them.
      qpos: of the joints [walker, joint], m and rad; the data's own.
      qvel: their rates, the data's own.
    """

    def __init__(self, spec: Any, num: int) -> None:
        """Makes walkers.

        Args:
          spec: the `mujoco.MjSpec` of one, whose joints are hinges and slides.
          num: of them.
        """
        self.model = without_solver(spec)
        self.num = num
        whole = mujoco.MjSpec()
        # Else MuJoCo warns that the bodies' options, other than the whole's, are lost.
        for name in ("timestep", "jacobian", "disableflags"):
            setattr(whole.option, name, getattr(spec.option, name))
        for number in range(num):
            whole.attach(spec.copy(), prefix=f"{number}/", frame=whole.worldbody.add_frame())
        self.data = mujoco.MjData(compiled(whole))
        self.qpos = self.data.qpos.reshape(num, -1)
        self.qvel = self.data.qvel.reshape(num, -1)
        self._walkers = np.arange(num)[:, None]
        self._rows = np.repeat(np.arange(self.model.nv), self.model.M_rownnz)
        self._columns = np.array(self.model.M_colind)

    def see(self) -> None:
        """Works out what follows from the joints and their rates."""
        mujoco.mj_fwdPosition(self.data.model, self.data)
        mujoco.mj_fwdVelocity(self.data.model, self.data)

    def ids(self, *names: str) -> Int[np.ndarray, "walker body"]:
        """Returns where bodies are among those of all walkers, which share the world."""
        own = [self.model.body(name).id for name in names]
        return (self.model.nbody - 1) * self._walkers + np.array(own)

    def moves(self, *names: str) -> Float[np.ndarray, "body 1 joint"]:
        """Returns 1 where a joint moves a body, else 0."""
        found = np.zeros((len(names), 1, self.model.nv))
        for row, name in enumerate(names):
            link = int(self.model.body(name).id)
            while link:
                first = int(self.model.body_dofadr[link])
                found[row, 0, first : first + int(self.model.body_dofnum[link])] = 1.0
                link = int(self.model.body_parentid[link])
        return found

    def of_joints(self, name: str) -> Float[np.ndarray, "walker joint"]:
        """Returns a field of the data that has a number for every joint."""
        return getattr(self.data, name).reshape(self.num, -1)

    def axes(self) -> Float[np.ndarray, "walker joint 6"]:
        """Returns how every joint moves what it moves: turn and shift, as C MuJoCo has them."""
        return self.data.cdof.reshape(self.num, -1, 6)

    def mass(self) -> Float[np.ndarray, "walker joint joint"]:
        """Returns the mass matrices."""
        rows, columns = self._rows, self._columns
        found = self.data.M.reshape(self.num, -1)
        mass = np.zeros((self.num, self.model.nv, self.model.nv))
        mass[:, rows, columns] = found
        mass[:, columns, rows] = found
        return mass

    def jacobian(
        self,
        points: Float[np.ndarray, "walker point 3"],
        moves: Float[np.ndarray, "point 1 joint"],
    ) -> Float[np.ndarray, "walker point 3 joint"]:
        """Returns what every joint does to points.

        From C MuJoCo's axes of motion, which it gives about each tree's centre of mass.

        Args:
          points: m.
          moves: of their bodies, from `moves`.
        """
        arms = points - self.centre()[:, None]
        x, y, z = arms[..., 0], arms[..., 1], arms[..., 2]
        shift = np.zeros((*arms.shape, 6))
        shift[..., 0, 1], shift[..., 0, 2] = z, -y
        shift[..., 1, 2], shift[..., 1, 0] = x, -z
        shift[..., 2, 0], shift[..., 2, 1] = y, -x
        shift[..., [0, 1, 2], [3, 4, 5]] = 1.0
        axes = np.swapaxes(self.axes(), 1, 2)
        found = shift.reshape(self.num, -1, 6) @ axes
        return found.reshape(*arms.shape, -1) * moves

    def centre(self) -> Float[np.ndarray, "walker 3"]:
        """Returns each walker's centre of mass, m."""
        first = (self.model.nbody - 1) * self._walkers[:, 0] + 1
        return self.data.subtree_com[first]


def without_solver(spec: Any) -> Any:
    """Returns the `mujoco.MjModel` without contacts, constraints and MuJoCo's implicit damping."""
    disable = mujoco.mjtDisableBit
    spec.option.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT
    spec.option.disableflags |= disable.mjDSBL_EULERDAMP
    return compiled(spec)


def torque_limits(model: Any, joints: list[int]) -> Float[np.ndarray, "motor 2"]:
    """Returns what motors give when C MuJoCo is told to give all, or the opposite of it, N m."""
    data = mujoco.MjData(model)
    found = np.full((model.nv, 2), (-np.inf, np.inf))
    for joint in np.flatnonzero(model.jnt_actfrclimited):
        found[joint] = model.jnt_actfrcrange[joint]
    for actuator in range(model.nu):
        joint = int(model.actuator_trnid[actuator][0])
        if not (model.actuator_ctrllimited[actuator] or model.actuator_forcelimited[actuator]):
            continue
        data.ctrl[:] = 0.0
        gave: list[float] = []
        for all_of_it in (-1e9, 1e9):
            data.ctrl[actuator] = all_of_it
            mujoco.mj_forward(model, data)
            gave.append(float(data.qfrc_actuator[joint]))
        found[joint] = sorted(gave)
    return found[joints]
