r"""The ant colony for one head over parts with several entry points (Li et al., 2019, section 2).

    (9)  p_ij = s_ij^alpha r_ij^beta d_ij^gamma / sum over l in Allow of s_il^alpha r_il^beta d_il^gamma
    (10) d_ij = (1 / X_j) / sum over l in Allow of 1 / X_l
    (11) s_ij <- theta s_ij + (1 - theta) D_ij
    (12) D_ij = sum over ants k of  Q / L_k  if tour k goes from i to j, else 0

Cities i, j are entry points and the home; s is pheromone, r_ij = 1 / length of the rapid, X the way along the
sheet, L_k the travel of ant k, homes included [mm]. ``ant_paths`` says which cities are in Allow: those that
keep clear rapids and neighbours only, if the rules ask for them, and how an ant without any goes back. The
preference for small X acts by (10) alone, if the rules price going back; otherwise d_ij is 1. The price is in
the value of a plan, by which the best one is kept, but not in L_k.

What the source leaves open, and how it is read here. Its parameters are not printed: the defaults are ours. A
rapid and the one back have pheromone of their own. All pheromone is 1 at first. The shortest tour of an
iteration gets (1 - theta) e Q / L once more. Lengths of 0 count as ``SHORTEST``; X is measured from the least x
of an entry point where that is negative, and is at least ``LEAST_X``. Where all neighbours are cut, an ant
drops neighbours only as well. Of the plans made the answer is the one that drops rules least
often, then the best.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.heuristics.ant_paths import Sheet, make_tours
from cutgap.heuristics.sides import Clock
from cutgap.instances import Instance, Plan, Rules, Visit, evaluate
from cutgap.instances.arrays import Floats, Ints, finite_number
from cutgap.instances.check import require_coordinates
from cutgap.instances.entry_tours import best_entries, entry_task
from cutgap.instances.process import WORD, Words, adjacent_parts, crossings, part_of, rapid_costs
from cutgap.instances.progress import Progress, Watch, nobody

SHORTEST = 1e-3
"""Length in mm that a rapid counts with in (9) and a tour in (12), at least."""

LEAST_X = 1.0
"""X in mm that a city counts with in (10), at least."""

FAINTEST = 1e-12
"""Pheromone never falls below: numerators of (9) stay above 0 for all exponents that are allowed."""

LARGEST_EXPONENT = 10.0


@dataclass(frozen=True, slots=True)
class AntColonyParameters:
    """Parameters of the ant colony; the source prints none.

    The defaults did best of a few settings on generated nests of 47 contours, at some 5 s a nest.

    Parameters
    ----------
    ants
        m, per iteration.
    iterations
        Number of times that all ants make a tour.
    pheromone_exponent, length_exponent, x_exponent
        alpha, beta and gamma of (9), 0 to 10.
    persistence
        theta, the share of pheromone that stays, 0 to below 1.
    deposit_mm
        Q; ``None`` takes the shortest length of the first iteration divided by m: a rapid in every such tour
        then keeps its pheromone of 1.
    elite
        e, the share of its deposit that the shortest tour adds a second time, 0 to below 1.
    dropped_price_mm
        What L_k of (12) counts for each rule that ant k dropped. The source has none (0): a tour across what is
        cut, being shorter, then draws the others after it.
    polish
        Whether the answer's entry points are made the best for its order, which the source does not do.
    """

    ants: int = 30
    iterations: int = 200
    pheromone_exponent: float = 1.0
    length_exponent: float = 2.0
    x_exponent: float = 1.0
    persistence: float = 0.9
    deposit_mm: float | None = None
    elite: float = 0.9
    dropped_price_mm: float = 0.0
    polish: bool = False

    def __post_init__(self) -> None:
        for name in ("ants", "iterations"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ValueError(f"ant colony, {name}: expected a whole number of at least 1, got {value!r}")
        for name in ("pheromone_exponent", "length_exponent", "x_exponent"):
            value = finite_number(getattr(self, name), f"ant colony, {name}", least=0.0)
            if value > LARGEST_EXPONENT:
                raise ValueError(f"ant colony, {name}: expected at most {LARGEST_EXPONENT:g}, got {value:g}")
            object.__setattr__(self, name, value)
        for name in ("persistence", "elite"):
            value = finite_number(getattr(self, name), f"ant colony, {name}", least=0.0)
            if value >= 1.0:
                raise ValueError(f"ant colony, {name}: expected less than 1, got {value:g}")
            object.__setattr__(self, name, value)
        price = finite_number(self.dropped_price_mm, "ant colony, dropped_price_mm", least=0.0)
        object.__setattr__(self, "dropped_price_mm", price)
        if self.deposit_mm is not None:
            value = finite_number(self.deposit_mm, "ant colony, deposit_mm", above=0.0)
            object.__setattr__(self, "deposit_mm", value)


def ant_colony(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: AntColonyParameters | None = None,
) -> Plan:
    """Plan one head; the plan may break clear rapids or neighbours only where every ant got stuck.

    Stopped by the time limit (in s) or by Ctrl-C, it returns the best plan so far; one iteration is made in any
    case.

    Raises
    ------
    ValueError
        For several heads or via points, or when a rule needs coordinates or curves that are not there.
    """
    if len(instance.heads) != 1:
        raise ValueError(f"ant-colony: expected one head, got {len(instance.heads)}")
    if rules.via_points:
        raise ValueError("ant-colony: takes no via points")
    require_coordinates(instance, rules)
    parameters = parameters or AntColonyParameters()
    if not instance.contours:
        return Plan(((),))
    colony = Colony(instance, rules, parameters)
    clock = Clock(time_limit)
    try:
        for iteration in range(parameters.iterations):
            if iteration > 0 and clock.over:
                break
            if colony.iterate(rng):
                watch(Progress(clock.seconds, value=colony.value()))
    except KeyboardInterrupt:
        if colony.best is None:
            raise
    return colony.answer()


class Colony:
    """Pheromone, and the best tour so far."""

    def __init__(self, instance: Instance, rules: Rules, parameters: AntColonyParameters) -> None:
        self.instance, self.rules, self.parameters = instance, rules, parameters
        self.sheet = sheet_of(instance, rules)
        self.costs = rapid_costs(instance, rules)
        self.attraction = attraction(instance, rules, parameters)
        self.pheromone = np.ones_like(self.attraction)
        self.deposit_mm = parameters.deposit_mm
        self.best: Ints | None = None
        self.best_value, self.dropped = np.inf, 0

    def iterate(self, rng: np.random.Generator) -> bool:
        """Let all ants make a tour, update the pheromone, and say whether there is a better tour."""
        tours = np.empty((self.parameters.ants, len(self.instance.contours)), dtype=np.int64)
        dropped = np.empty(len(tours), dtype=np.int64)
        weights = self.pheromone**self.parameters.pheromone_exponent * self.attraction
        make_tours(self.sheet, weights, tours, dropped, rng)
        closed = closed_tours(self.instance, tours)
        lengths = np.maximum(leg_sums(self.instance.rapids, closed), SHORTEST)
        if self.deposit_mm is None:
            self.deposit_mm = float(lengths.min()) / len(tours)
        counted = lengths + self.parameters.dropped_price_mm * dropped
        update_pheromone(self.pheromone, closed, counted, self.deposit_mm, self.parameters)
        values = lengths + leg_sums(self.costs - self.instance.rapids, tours)
        ant = int(np.lexsort((values, dropped))[0])
        if self.best is not None and (dropped[ant], values[ant]) >= (self.dropped, self.best_value):
            return False
        self.best, self.best_value, self.dropped = tours[ant], float(values[ant]), int(dropped[ant])
        return True

    def plan(self) -> Plan:
        """Return the best plan so far."""
        assert self.best is not None  # the first iteration keeps a tour
        contours = self.sheet.owner[self.best]
        entries = self.best - self.instance.first_node[contours]
        return Plan((tuple(map(Visit, contours.tolist(), entries.tolist())),))

    def value(self) -> float | None:
        """Return the value of the best plan so far, ``None`` when a rule was dropped for it."""
        return evaluate(self.instance, self.plan()).objective(self.rules) if self.dropped == 0 else None

    def answer(self) -> Plan:
        """Return the best plan, polished if asked for."""
        plan = self.plan()
        if not self.parameters.polish:
            return plan
        order = [visit.contour for visit in plan.tours[0]]
        tour = best_entries(entry_task(self.instance, self.rules), order)
        return Plan((tour.visits,)) if tour.barred == 0 else plan


def attraction(instance: Instance, rules: Rules, parameters: AntColonyParameters) -> Floats:
    """Return r^beta / X^gamma, shape (nodes + 1, nodes): the sum in (10) cancels in (9).

    The last row is for ants that may begin anywhere: every city alike.
    """
    lengths = np.maximum(instance.rapids, SHORTEST)
    x = instance.points[:, 0]
    x = np.maximum(x - min(0.0, float(x.min())), LEAST_X)
    gamma = parameters.x_exponent if rules.backward_price > 0 else 0.0
    factors = lengths**-parameters.length_exponent * x**-gamma
    return np.vstack((factors, np.ones(len(x))))


def update_pheromone(
    pheromone: Floats,
    tours: Ints,
    lengths: Floats,
    deposit_mm: float,
    parameters: AntColonyParameters,
) -> None:
    """Apply (11) and (12), the second time for the shortest tour included.

    Parameters
    ----------
    tours
        Nodes of each ant from its start back to it, shape (ants, contours + 1 or + 2).
    lengths
        L_k, shape (ants,), mm.
    """
    deposits = deposit_mm / lengths
    deposits[np.argmin(lengths)] *= 1.0 + parameters.elite
    increment = np.zeros_like(pheromone)
    np.add.at(increment, (tours[:, :-1], tours[:, 1:]), deposits[:, None])
    pheromone *= parameters.persistence
    pheromone += (1.0 - parameters.persistence) * increment
    np.maximum(pheromone, FAINTEST, out=pheromone)


def closed_tours(instance: Instance, tours: Ints) -> Ints:
    """Return tours with the home at both ends, or with the first city again at the end."""
    home = instance.home_node(0)
    if home is None:
        return np.column_stack((tours, tours[:, 0]))
    return np.pad(tours, ((0, 0), (1, 1)), constant_values=home)


def leg_sums(lengths: Floats, tours: Ints) -> Floats:
    """Return the sum of the lengths along each row of cities, mm."""
    return lengths[tours[:, :-1], tours[:, 1:]].sum(axis=1)


def sheet_of(instance: Instance, rules: Rules) -> Sheet:
    """Return what the ants read, in copies: kernels are compiled anew for arrays that are read-only."""
    parts, home = part_of(instance), instance.home_node(0)
    count, places = int(parts.max()) + 1, int(instance.first_node[-1])
    before, outside = preceding(instance, parts, count)
    return Sheet(
        lengths=np.vstack((instance.rapids, np.zeros(instance.node_count))),
        first_node=instance.first_node,
        owner=np.repeat(np.arange(len(parts)), np.diff(instance.first_node)),
        parts=parts,
        before=before,
        outside=outside,
        crossed=np.array(crossings(instance))
        if rules.clear_rapids
        else np.zeros((places, places, 0), dtype=np.uint64),
        adjacent=np.array(adjacent_parts(instance))
        if rules.neighbours_only
        else np.ones((count, count), dtype=np.bool_),
        in_one_go=rules.parts_in_one_go,
        start=instance.node_count if home is None else home,
    )


def preceding(instance: Instance, parts: Ints, count: int) -> tuple[Words, Words]:
    """Return the contours to be cut before each contour, and before each part those of other parts."""
    words = (len(parts) + WORD - 1) // WORD
    before: Words = np.zeros((len(parts), words), dtype=np.uint64)
    outside: Words = np.zeros((count, words), dtype=np.uint64)
    for a, b in instance.precedence:
        bit = np.uint64(1 << a % WORD)
        before[b, a // WORD] |= bit
        if parts[a] != parts[b]:
            outside[parts[b], a // WORD] |= bit
    return before, outside
