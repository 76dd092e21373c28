"""What is counted in trials, and the rules that end them, once more in float64 numpy."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import FitnessTerms
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.own_laws import (
    AlongHeading,
    Arrival,
    Forbidden,
    HindmostAnkle,
    LowCentre,
    Standstill,
)
from mjxwalk.verify.reference import Reference
from mjxwalk.verify.stepping import Step
from mjxwalk.verify.terms import Terms, lowest

MAX_SPEEDS = {"m": 50.0, "rad": 1000.0}  # m/s, rad/s; beyond, the physics has diverged


class Tally(NamedTuple):
    """Walkers' trials so far; its arrays are filled in place.

    Attributes:
      steps: of the physics.
      flight_time: since a foot last touched the ground, s.
      torque_cost: N m s.
      work: J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged.
      contact: which feet touched the ground in the last step.
      ankle_x: how far each ankle was ahead of the hips then, m.
      asked: of each motor then; see `mjxwalk.envs.own_laws.Standstill`.
      still_time: for how long that has stood still, s.
    """

    steps: Any
    flight_time: Any
    torque_cost: Any
    work: Any
    fell: Any
    diverged: Any
    contact: Any
    ankle_x: Any
    asked: Any
    still_time: Any


class Rules:
    """The rules of the trials that walkers are in, and what is counted.

    Attributes:
      tally: of the trials.
    """

    def __init__(self, reference: Reference, touching: Any, ankle_x: Any) -> None:
        """Begins trials.

        Args:
          reference: the walkers.
          touching: which points touch the ground [walker, point].
          ankle_x: how far each ankle is ahead of the hips [walker, leg], m.
        """
        self._reference, self._env = reference, reference.env
        self._anatomy, self._own = reference.anatomy, reference.own_laws
        self._speeds = np.array([MAX_SPEEDS[each.unit] for each in self._anatomy.coordinates])
        self._points = [self._anatomy.points_of(leg) for leg in self._anatomy.legs]
        self._standing = standing_height(reference)
        num = len(touching)
        terms = [law for law in self._own.get("fitness", ()) if isinstance(law, FitnessTerms)]
        self._terms = [Terms(law, reference) for law in terms]
        self.tally = Tally(
            steps=np.zeros(num, int),
            flight_time=np.zeros(num),
            torque_cost=np.zeros(num),
            work=np.zeros(num),
            fell=np.zeros(num, bool),
            diverged=np.zeros(num, bool),
            contact=self._feet(np.asarray(touching)),
            ankle_x=np.array(ankle_x, np.float64),
            asked=np.zeros((num, len(self._anatomy.motors))),
            still_time=np.zeros(num),
        )

    def judge(
        self,
        walking: Bool[np.ndarray, " walker"],
        step: Step,
        before: tuple[Any, Any],
        action: Float[np.ndarray, "field walker motor"],
    ) -> Bool[np.ndarray, " walker"]:
        """Counts a step of those that walk, and returns whose trial is over.

        Args:
          walking: who walks.
          step: what the step was.
          before: coordinates and rates before it; whoever has diverged is put back there.
          action: of the step; its first field is what a velocity motor is asked for.
        """
        asked = action[0]
        reference, tally, dt = self._reference, self.tally, self._env.timestep
        sound = self._sound()
        broken: Any = walking & ~sound
        touching = self._feet(step.push.touching)
        resting = np.abs(asked - tally.asked) < self._still_rate() * dt
        power = np.abs(step.torque * step.rate).sum(axis=1)
        counted = walking & sound
        for terms in self._terms:
            terms.count(counted, before, action, tally.contact)
        for held, value in (
            (tally.steps, tally.steps + 1),
            (tally.flight_time, np.where(touching.any(axis=1), 0.0, tally.flight_time + dt)),
            (tally.torque_cost, tally.torque_cost + dt * np.abs(step.torque).sum(axis=1)),
            (tally.work, tally.work + dt * power),
            (tally.contact, touching),
            (tally.ankle_x, self._ahead(step, before[0])),
            (tally.asked, asked),
            (tally.still_time, np.where(resting.all(axis=1), tally.still_time + dt, 0.0)),
        ):
            held[counted] = value[counted]
        for now, then in zip((reference.qpos, reference.qvel), before, strict=True):
            now[broken] = then[broken]
        tally.diverged[broken] = True
        tally.fell[walking] = (self._fallen(step, before[0]) | broken)[walking]
        lag = self._env.min_speed * dt * tally.steps - self.x
        spent = tally.torque_cost >= self._env.torque_budget
        late = tally.steps >= round(self._env.max_time / dt)
        return tally.fell | spent | late | (lag > self._env.max_lag) | self._over()

    def sensed(self) -> dict[str, Any]:
        """Returns what walkers sense of their trials, by name; see `mjxwalk.verify.senses`."""
        return {
            "time": self.tally.steps * self._env.timestep,
            "contact": self.tally.contact,
            "ankle_x": self.tally.ankle_x,
        }

    @property
    def x(self) -> Any:
        """How far the hips have come [walker], m."""
        return self._reference.qpos[:, self._anatomy.root.forward]

    def fitness(self) -> Any:
        """Returns the fitness of walkers whose trials have ended [walker]."""
        for terms in self._terms:
            return terms.worth(self.tally)
        for law in self._own.get("fitness", ()):
            if isinstance(law, HindmostAnkle):
                in_vain = self.tally.fell & (self._hindmost < law.fallen_distance)
                return np.where(in_vain, 0.0, self._hindmost)
        return self.x.copy()

    @property
    def _hindmost(self) -> Float[np.ndarray, " walker"]:
        return self.x + self.tally.ankle_x.min(axis=1)

    def _feet(self, touching: Any) -> Bool[np.ndarray, "walker leg"]:
        """Returns which feet touch the ground, of [walker, point]."""
        return np.stack([touching[:, points].any(axis=1) for points in self._points], axis=1)

    def _sound(self) -> Bool[np.ndarray, " walker"]:
        """Returns whose physics has not diverged."""
        with np.errstate(invalid="ignore", over="ignore"):
            return ((self._reference.qvel / self._speeds) ** 2).sum(axis=1) < 1.0

    def _ahead(self, step: Step, before: Any) -> Float[np.ndarray, "walker leg"]:
        """Returns how far each ankle was ahead of the hips, m: along x, or as the torso headed."""
        root = self._anatomy.root
        along = step.feet[..., 0] - before[:, [root.forward]]
        if AlongHeading() not in self._own.get("ankles", ()):
            return along
        yaw = before[:, [root.yaw]]
        across = step.feet[..., 1] - before[:, [root.sideways]]
        return np.cos(yaw) * along + np.sin(yaw) * across

    def _fallen(self, step: Step, before: Any) -> Bool[np.ndarray, " walker"]:
        """Returns who flies, is tilted or is low."""
        reference, root = self._reference, self._anatomy.root
        fallen = self.tally.flight_time > self._env.max_flight_time
        for turn, most in self._env.max_tilt.items():
            fallen |= np.abs(reference.qpos[:, getattr(root, turn)]) > most
        if self._env.lowest_hips is not None:
            over = reference.qpos[:, root.height] - reference.height(reference.qpos)
            fallen |= over < self._env.lowest_hips
        for law in self._own.get("is_low", ()):
            if isinstance(law, LowCentre):
                over = step.centre[:, 2] - reference.height(before)
                fallen |= over < law.share * self._standing
            elif isinstance(law, Forbidden) and law.bodies:
                over = reference.over_ground(reference.places(*law.bodies))
                fallen |= (over < np.array(law.radii)).any(axis=1)
        return fallen

    def _still_rate(self) -> float:
        rates = [law.rate for law in self._own.get("is_over", ()) if isinstance(law, Standstill)]
        return min(rates, default=0.0)

    def _over(self) -> Bool[np.ndarray, " walker"]:
        """Returns whose trial a rule of the body's own ends without a fall."""
        over = np.zeros(len(self.x), bool)
        for law in self._own.get("is_over", ()):
            if isinstance(law, Arrival):
                over |= self._hindmost >= law.distance
            elif isinstance(law, Standstill):
                over |= self.tally.still_time > law.time
        return over


def standing_height(reference: Reference) -> float:
    """Returns how high the centre of mass is over the soles when all coordinates are 0, m."""
    data = mujoco.MjData(reference.herd.model)
    mujoco.mj_forward(reference.herd.model, data)
    return float(data.subtree_com[1, 2]) - lowest(reference, data)
