"""Bodies under MuJoCo's own contacts, to be walked alike by our engines, by MJX and by C MuJoCo.

One step of control is `HELD` steps of the physics: a perceptron, or without hidden layers a linear
policy, reads positions and velocities, and the motors hold what it asks for until the next. Every
walker has weights of its own, as in an evolution. Nothing ends a trial but its length.
"""

import copy
import dataclasses
import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from mjxwalk import robots
from mjxwalk.bench.workload import Walked, Workload, fixed_steps
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import anatomy, file_tree, motors
from mjxwalk.envs.derived.source import PLANE
from mjxwalk.envs.gymnasium import files
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.motor import Action
from mjxwalk.envs.mujoco_law import coordinates
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.envs.mujoco_law import step as mujoco_step
from mjxwalk.envs.mujoco_law.coordinates import Coordinates
from mjxwalk.envs.mujoco_law.forward import MujocoState
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.settings import MujocoContact

HELD = 5  # steps of the physics that an action is held for
SECONDS = 1.0  # of a trial; ours: walkers stand, stumble and lie on the ground in it
DAMPED = 0.2  # of a joint's speed, in a step
REACH = 0.3  # rad off the joint's start that an action of 1 asks for; ours
WEIGHT_SIGMA = 0.03  # of the last layer's weights; ours: walkers stumble, few jump
START_RATE = 0.1  # of the noise of velocities at the start, m/s and rad/s; ours
FEW_ITERATIONS = MujocoContact(iterations=1, ls_iterations=4, integrator="euler")
# What a walk returns, as a tree.
WALKED = Walked(MujocoState(0, 0, 0), 0)  # type: ignore[arg-type]


class Layer(NamedTuple):
    """Weights from a layer's inputs to its units, and the units' biases."""

    weights: Any  # [*pop, to, from]
    biases: Any  # [*pop, to]


class Motors(NamedTuple):
    """What a control is of an action's number, and what a motor does besides giving the control."""

    offset: Float[np.ndarray, " motor"]  # control of 0, N m
    scale: Float[np.ndarray, " motor"]  # change of the control by 1, N m
    stiffness: Float[np.ndarray, " motor"]  # N m/rad
    damping: Float[np.ndarray, " motor"]  # N m s/rad


@dataclasses.dataclass(frozen=True, kw_only=True)
class ContactBody:
    """A body and its policy; a motor gives control - stiffness * angle - damping * rate.

    Attributes:
      body: MJCF, in itself complete.
      law: options of the physics.
      hidden: units of the policy's hidden layers.
    """

    body: str = dataclasses.field(repr=False)
    law: MujocoContact = FEW_ITERATIONS
    hidden: tuple[int, ...] = ()

    @property
    def model(self) -> MujocoModel:
        """The body under our law."""
        return _model(self.body, self.law)

    @property
    def motors(self) -> Motors:
        """Its motors, in the order of the model's actuators."""
        return _motors(self.body, self.law)

    @property
    def num_actions(self) -> int:
        """Steps of control in a trial."""
        return round(SECONDS / float(self.model.mujoco.opt.timestep) / HELD)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers that the policy reads, units of its hidden layers, and numbers of an action."""
        model = self.model
        seen = model.mujoco.nq - _unseen(model) + model.mujoco.nv
        return seen, *self.hidden, len(model.driven)

    @property
    def linear(self) -> "ContactBody":
        """The same body with a linear policy."""
        return dataclasses.replace(self, hidden=())

    @property
    def control_operations(self) -> int:
        """Multiplications and additions of a step of control."""
        return sum(2 * num * to for num, to in zip(self.sizes[:-1], self.sizes[1:], strict=True))

    @property
    def is_straight(self) -> bool:
        """Whether a step of the physics has no loops, so that its operations can be counted."""
        return self.law.iterations == 1 and self.law.integrator == "euler"

    def operations(self, of_kernel: int) -> int:
        """Returns the scalar operations of a step of the physics, and of its share of the control.

        Args:
          of_kernel: operations of the lanes engine's kernel with a linear policy, which count a
            step of the physics and a step of control.
        """
        physics = of_kernel - self.linear.control_operations
        return physics + round(self.control_operations / HELD)

    def c_model(self) -> Any:
        """Returns the same body as a `mujoco.MjModel` whose controls are those of the policy."""
        found, own = copy.deepcopy(self.model.mujoco), self.motors
        found.actuator_gainprm[:, 0] = 1.0
        # A body is one island of constraints; C MuJoCo is some 8 % faster if it does not look for
        # others.
        found.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
        nothing = np.zeros_like(own.stiffness)
        found.actuator_biasprm[:, :3] = np.stack([nothing, -own.stiffness, -own.damping], axis=1)
        return found

    def starts(self, size: int) -> Any:
        """Returns the states [pop, ...] of walkers on their feet, with velocities of their own."""
        model = self.model
        qpos = _standing(self.body, model)
        draws = np.random.default_rng(0).normal(0.0, START_RATE, (size, model.mujoco.nv))
        places = np.repeat(qpos[None], size, axis=0)
        values: Any = places, draws.astype(np.float32), np.zeros(draws.shape, np.float32)
        return MujocoState(*values)

    def genotypes(self, size: int) -> tuple[Layer, ...]:
        """Returns the weights of policies, drawn at random, [pop, ...]."""
        layers: list[Layer] = []
        for place, (num, to) in enumerate(zip(self.sizes[:-1], self.sizes[1:], strict=True)):
            sigma = WEIGHT_SIGMA if place == len(self.hidden) else 1.0 / np.sqrt(num)
            draws = np.random.default_rng((1, place))  # the first walkers are those of fewer
            weights = draws.normal(0.0, sigma, (size, to, num)).astype(np.float32)
            layers.append(Layer(weights, np.zeros((size, to), np.float32)))
        return tuple(layers)

    def workload(self, size: int) -> Workload:
        """Returns what our engines, and `jax.vmap`, walk."""
        return Workload(
            self.start, self.advance, self.genotypes(size), self.starts(size), (0, 0), HELD
        )

    def start(self, genotype: Any, given: MujocoState) -> MujocoState:
        """Returns a walker's state at the start."""
        del genotype
        return given

    def advance(self, genotype: Any, given: Any, state: MujocoState) -> MujocoState:
        """Returns a walker's state one step of control later."""
        del given
        ctrl = self.control(genotype, state.qpos, state.qvel)
        model, own = self.model, self.motors
        held = jnp.asarray(own.stiffness), jnp.asarray(own.damping)
        action = Action(ctrl, jnp.zeros_like(ctrl), *held)

        def substep(_: Any, at: MujocoState) -> MujocoState:
            return mujoco_step.step(model, at, action)[0]

        return jax.lax.fori_loop(0, HELD, substep, state)

    def walk(self, genotype: Any, given: MujocoState, num: Int[Array, ""]) -> Walked:
        """Returns a walker after so many steps of control."""
        return fixed_steps(self.start, self.advance, genotype, given, num)

    def control(
        self,
        genotype: tuple[Layer, ...],
        qpos: Float[Array, " nq"],
        qvel: Float[Array, " nv"],
    ) -> Float[Array, " motor"]:
        """Returns the controls that one walker's policy asks for."""
        values, own = jnp.concatenate([qpos[_unseen(self.model) :], qvel]), self.motors
        for layer in genotype[:-1]:
            values = jnp.tanh(layer.weights @ values + layer.biases)
        asked = genotype[-1].weights @ values + genotype[-1].biases
        return jnp.asarray(own.offset) + own.scale * jnp.clip(asked, -1.0, 1.0)

    def controls(
        self,
        genotypes: tuple[Layer, ...],
        qpos: Float[np.ndarray, "pop nq"],
        qvel: Float[np.ndarray, "pop nv"],
    ) -> Any:
        """Returns the same of all walkers [pop, motor], computed by NumPy."""
        seen = np.concatenate([qpos[:, _unseen(self.model) :], qvel], axis=1)
        values, own = seen.astype(np.float32), self.motors
        for place, layer in enumerate(genotypes):
            values = np.matmul(layer.weights, values[..., None])[..., 0] + layer.biases
            if place < len(genotypes) - 1:
                values = np.tanh(values)
        return own.offset + own.scale * np.clip(values, -1.0, 1.0)


@functools.cache
def _model(text: str, law: MujocoContact) -> MujocoModel:
    """Returns the model of a body with its file's time step."""
    return mujoco_model.of_text(text, law, float(mujoco.MjSpec.from_string(text).option.timestep))


@functools.cache
def _motors(text: str, law: MujocoContact) -> Motors:
    """Returns motors that hold targets by the file's gains, or else by gains of our own.

    ours: damping takes a fifth of a joint's speed in a step, as C MuJoCo's explicit motors stay
    stable by that, and stiffness is what this damps critically.
    """
    model = _model(text, law)
    found, state = model.mujoco, _standing(text, model)
    data = mujoco.MjData(found)
    data.qpos[:] = state
    mujoco.mj_forward(found, data)
    mass = np.zeros((found.nv, found.nv))
    mujoco.mj_fullM(found, data, mass)
    inertia = 1.0 / np.diag(np.linalg.inv(mass))[model.driven]
    timestep = float(found.opt.timestep)
    own = [(each.stiffness, each.damping) for each in motors.of_tree(file_tree.of_text(text))]
    stiffness, damping = np.array(own).T
    without = stiffness == 0.0
    damping = np.where(without, DAMPED * inertia / timestep, damping)
    stiffness = np.where(without, inertia * (0.5 * DAMPED / timestep) ** 2, stiffness)
    start = state[model.driven + found.nq - found.nv]
    values = stiffness * start, REACH * stiffness, stiffness, damping
    return Motors(*(each.astype(np.float32) for each in values))


def _standing(text: str, model: MujocoModel) -> Float[np.ndarray, " nq"]:
    """Returns the positions of a body on its feet."""
    stance = anatomy.stance(text)
    with jax.ensure_compile_time_eval():
        at = Coordinates(jnp.asarray(stance.qpos), jnp.zeros(len(stance.qpos)))
        qpos: Any = coordinates.from_coordinates(model, at)[0]
        return np.asarray(qpos, np.float32)


def _unseen(model: MujocoModel) -> int:
    """Returns how many positions a policy does not read: those along the ground."""
    return 1 if model.planar else 2


def gymnasium(file: str) -> Callable[[], ContactBody]:
    """Returns what makes a body of one of Gymnasium's files, as it is.

    Raises:
      ValueError: when called, if Gymnasium is not installed.
    """

    def make() -> ContactBody:
        text = files.text(file)
        if not text:
            raise ValueError(
                f"{file} comes with gymnasium, which is not installed; {files.INSTALL}"
            )
        return ContactBody(body=text)

    return make


def shipped(name: str) -> Callable[[], ContactBody]:
    """Returns what makes a body that ships."""
    return lambda: ContactBody(body=_text(name))


@functools.cache
def _text(name: str) -> str:
    """Returns a body's MJCF; one whose shapes touch nothing gets a sphere at each of its sites.

    They are where our own contact law has its contact points.
    """
    text = reader.read(robots.path(name)).text
    spec = mujoco.MjSpec.from_string(text)
    shapes = [geom for geom in spec.geoms if int(geom.type) != PLANE]
    if any(geom.contype or geom.conaffinity for geom in shapes):
        return text
    for floor in (geom for geom in spec.geoms if int(geom.type) == PLANE):
        floor.contype = 1
    for site in list(spec.sites):
        site.parent.add_geom(
            name=f"sole {site.name}", type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=site.pos,
            size=site.size, mass=0.0, contype=0, conaffinity=1,
        )  # fmt: skip
    return str(spec.to_xml())
