r"""The dual-coded genetic algorithm: order and start points, travel against heat (Yang, Liu, Ju, 2012).

A chromosome has two rows, the order of the contours and the start of each. A generation is selected by fitness
(``dual_coded_fitness``); children come from crossover and mutation, each one of three at random
(``dual_coded_operators``). A child that goes across what is cut, if rapids must be clear, or that breaks
precedence, is generated again. For travel alone, F' = 1 / f_1, the source has an "improved" variant, which is
otherwise the same, and a "conventional" one.

What the source leaves open, and how it is read here:

- Selection is a roulette wheel. No individual survives for being the best; the answer is the best one of all
  generations, by fewest rapids across what is cut, then least excess over the cap, then F'.
- Chances of crossover and mutation are 0.9: of 0.1 to 0.9 these gave about the shortest routes.
- Starts are crossed contour by contour, with one even share for all. The start of one contour mutates, with
  b = 2: with Michalewicz' 5 the rounded steps are soon 0.
- Random orders nearly always cross what is cut, so routes of the first generation are drawn step by step among
  what can be reached. A child is generated 20 times at most, then a parent stays.
- "Conventional" is the same encoding with order crossover (OX), swaps, new starts at random, and F = F'.
"""

import numba
import numpy as np

from cutgap.heuristics.dual_coded_fitness import DualCodedParameters, raw_fitness, scaled, travel_unit
from cutgap.heuristics.dual_coded_operators import Operators, breed
from cutgap.heuristics.hot_routes import (
    Plate,
    barred_steps,
    peak_rise,
    plan_of_route,
    plate_of,
    random_route,
    travel_of,
)
from cutgap.heuristics.sides import Clock
from cutgap.instances import Instance, Plan, Rules, evaluate
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.check import TOLERANCE, require_coordinates
from cutgap.instances.heat import require_heat
from cutgap.instances.progress import Progress, Watch, nobody

Front = tuple[Floats, Floats, Ints, Ints]
"""Travel in mm, peak rise in K, order and starts of each individual."""


def dual_coded(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: DualCodedParameters | None = None,
) -> Plan:
    """Plan one head by the fitness (1), whatever the objective of the rules; the cap T_s is theirs.

    Stopped by the time limit (in s) or by Ctrl-C, it returns the best plan so far; one route is made in any
    case.

    Raises
    ------
    ValueError
        For several heads, a given matrix, rules that it does not know, or without material or curves.
    """
    require_dual_coded(instance, rules)
    if not instance.contours:
        return Plan(((),))
    plate = plate_of(instance, rules)
    return evolve(instance, rules, parameters or DualCodedParameters(), plate, rng, watch, time_limit).answer


def front_of_population(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    time_limit: float | None = None,
    parameters: DualCodedParameters | None = None,
) -> list[Plan]:
    """Return the plans of a run of ``dual_coded`` that no other beats in travel and peak, by rising travel.

    They keep the rules, so there are none where no individual kept a temperature cap.
    """
    require_dual_coded(instance, rules)
    if not instance.contours:
        return [Plan(((),))]
    plate = plate_of(instance, rules)
    population = evolve(instance, rules, parameters or DualCodedParameters(), plate, rng, nobody, time_limit)
    return [plan_of_route(order, starts) for order, starts in zip(*population.front[2:], strict=True)]


def require_dual_coded(instance: Instance, rules: Rules) -> None:
    """Raise ``ValueError`` for what the algorithm does not take."""
    if len(instance.heads) != 1:
        raise ValueError(f"dual-coded: expected one head, got {len(instance.heads)}")
    if instance.machine.metric == "matrix":
        raise ValueError(
            f"dual-coded: instance {instance.name!r} has a matrix, and no coordinates to jump between"
        )
    if rules.via_points or rules.parts_in_one_go or rules.neighbours_only:
        raise ValueError(
            "dual-coded: takes no via points, parts in one go or neighbours only; drop these rules"
        )
    require_coordinates(instance, rules)
    require_heat(instance)


def has_hot_route(instance: Instance, rules: Rules) -> bool:
    """Whether the algorithm takes the instance and rules."""
    try:
        require_dual_coded(instance, rules)
    except ValueError:
        return False
    return bool(instance.contours)


def evolve(
    instance: Instance,
    rules: Rules,
    parameters: DualCodedParameters,
    plate: Plate,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
) -> "Population":
    """Run the generations on a plate of the instance."""
    clock = Clock(time_limit)
    population = Population(instance, rules, parameters, plate, rng, clock)
    try:
        for generation in range(parameters.generations + 1):
            if generation > 0:
                if clock.over:
                    break
                population.breed(generation, rng)
            if population.improved:
                watch(Progress(clock.seconds, value=population.value()))
    except KeyboardInterrupt:
        pass
    return population


class Population:
    """One generation, and of all so far the best individual, its ``figures`` (travel, rise), and the front."""

    def __init__(
        self,
        instance: Instance,
        rules: Rules,
        parameters: DualCodedParameters,
        plate: Plate,
        rng: np.random.Generator,
        clock: Clock,
    ) -> None:
        self.instance, self.rules, self.parameters, self.plate = instance, rules, parameters, plate
        self.travel_unit = travel_unit(plate, parameters)
        ambient = require_heat(instance).ambient_c
        self.room = np.inf if rules.temperature_cap is None else rules.temperature_cap - ambient
        self.operators = Operators(
            parameters.crossover_probability,
            parameters.mutation_probability,
            parameters.start_shape,
            parameters.tries,
            parameters.conventional,
        )
        nothing = np.empty((0, len(instance.contours)), dtype=np.int64)
        self.front: Front = (np.empty(0), np.empty(0), nothing, nothing)
        self.score = (np.inf, np.inf, np.inf)
        self.orders, self.starts = first_generation(plate, parameters.population, rng, clock)
        self.measure()

    def breed(self, generation: int, rng: np.random.Generator) -> None:
        """Go on to a generation n >= 1 of (3)."""
        parameters = self.parameters
        fitness = self.fitness if parameters.conventional else scaled(self.fitness, generation, parameters)
        wheel = np.cumsum(fitness) / fitness.sum()
        wheel[-1] = 1.0
        chosen = np.searchsorted(wheel, rng.random(len(wheel) + 1), side="left")
        progress = generation / parameters.generations
        self.orders, self.starts = breed(
            self.plate, self.operators, self.orders, self.starts, chosen, progress, rng
        )
        self.measure()

    def measure(self) -> None:
        """Take the figures of the generation, and keep its best individual and its share of the front."""
        travels, rises, barred = measure(self.plate, self.orders, self.starts)
        self.fitness = raw_fitness(travels / self.travel_unit, rises, self.room, self.parameters)
        # By the cap's own rise, as in ``check``: an infinite rise would allow itself an infinite slack.
        over = rises > self.room + TOLERANCE * max(1.0, abs(self.room))
        excess = np.subtract(rises, self.room, out=np.zeros(len(rises)), where=over)
        best = int(np.lexsort((-self.fitness, excess, barred))[0])
        score = (float(barred[best]), float(excess[best]), -float(self.fitness[best]))
        self.improved = score < self.score
        if self.improved:
            self.score, self.answer = score, plan_of_route(self.orders[best], self.starts[best])
            self.figures = (float(travels[best]), float(rises[best]))
        kept = (barred == 0) & (excess == 0.0)
        self.front = merged_front(
            self.front, (travels[kept], rises[kept], self.orders[kept], self.starts[kept])
        )

    def value(self) -> float | None:
        """Return the value of the best individual, ``None`` while it breaks a rule."""
        return evaluate(self.instance, self.answer).objective(self.rules) if self.score[:2] == (0, 0) else None


def merged_front(one: Front, other: Front) -> Front:
    """Return the individuals that no other beats, by rising travel."""
    travels, rises, orders, starts = (np.concatenate(pair) for pair in zip(one, other, strict=True))
    by_travel = np.lexsort((rises, travels))
    lowest = np.minimum.accumulate(rises[by_travel])
    kept = by_travel[np.concatenate(([True], lowest[1:] < lowest[:-1]))[: len(by_travel)]]
    return travels[kept], rises[kept], orders[kept], starts[kept]


def first_generation(plate: Plate, size: int, rng: np.random.Generator, clock: Clock) -> tuple[Ints, Ints]:
    """Return random routes, shape (size, contours) each row; copies of the first once the time is over."""
    orders, starts = np.zeros((2, size, len(plate.before)), dtype=np.int64)
    for i in range(size):
        if i > 0 and clock.over:
            orders[i:], starts[i:] = orders[0], starts[0]
            break
        random_route(plate, orders[i], starts[i], rng)
    return orders, starts


@numba.njit(cache=True)
def measure(plate: Plate, orders: Ints, starts: Ints) -> tuple[Floats, Floats, Ints]:
    """Return travel in mm, peak rise in K and barred steps of each individual."""
    size, count = orders.shape
    travels, rises, barred = np.empty(size), np.empty(size), np.empty(size, np.int64)
    ends = np.empty(count)
    for i in range(size):
        travels[i] = travel_of(plate, orders[i], starts[i])
        rises[i] = peak_rise(plate, orders[i], starts[i], ends)
        barred[i] = barred_steps(plate, orders[i], starts[i], count)
    return travels, rises, barred
