r"""Is there an order in which no contour alone heats a later start point above a level? CP-SAT, on integers.

    Sets       v, w    points, of contours i = i(v), j
    Data       D_vw    scale times the work on i(v) and the way v -> w                       [1 / scale s]
               A_vj, B_vj   the start at v is too warm from j when A < start of i(v) - start of j < B
               H       latest start                                                          [1 / scale s]
    Variables  e_v     contour i is started at v                                             [-]
               y_vw    w comes right after v;  f_v, g_v   v is the first, the last           [-]
               t_i     start of contour i, floor of scale times its true start               [1 / scale s]
               b_vj    j is late enough, or not before i, to leave v cool                    [-]
    (once i)        exactly one e_v with v of i
    (circuit)       the arcs y, f from a depot and g to it form one circuit, which is off v when not e_v
    (time v w)      y_vw  =>  floor D_vw <= t_j - t_i <= ceil D_vw;   f_v  =>  t_i = 0
    (cool v j)      b_vj  =>  t_i - t_j <= A_vj;   e_v and not b_vj  =>  t_i - t_j >= B_vj
    (one by one)    the intervals from t_i, as long as the floor of scale times the work on i, do not overlap;
                    implied
    (precedence)    t_a <= t_b

Where there are many points, the nodes of the circuit are contours: a step from i to j then takes between the
least and the largest D over their points, which only adds plans.

Source: cut windows of the kernel, (4) of ``instances.heat``.
"""

import threading
from dataclasses import dataclass
from itertools import pairwise

from ortools.sat.python import cp_model

from cutgap.formulations.cpsat.worker import Send, serve, stop_when_asked

Window = tuple[int, int, int, int | None]
"""Point v, contour j, A and B; B is ``None`` when the window has no end."""


@dataclass(frozen=True, slots=True)
class Question:
    """The data above; asks for a plan within ``seconds``.

    Attributes
    ----------
    stops
        Contour of each node of the circuit: of each point, or 0..n-1 when whole contours are its nodes.
    spans
        D_vw rounded down and up, from node to node; ``None`` where the step is forbidden.
    """

    first: tuple[int, ...]
    stops: tuple[int, ...]
    spans: list[list[tuple[int, int] | None]]
    windows: list[Window]
    horizon: int
    works: tuple[int, ...]
    precedence: tuple[tuple[int, int], ...]
    seconds: float | None
    workers: int
    memory_mib: int


class CoolModel:
    """The model, one method per constraint family."""

    def __init__(self, asked: Question) -> None:
        self.asked, self.model = asked, cp_model.CpModel()
        count = len(asked.first) - 1
        self.contour_of = [i for i, (a, b) in enumerate(pairwise(asked.first)) for _ in range(a, b)]
        self.chosen = [self.model.new_bool_var(f"e{v}") for v in range(asked.first[-1])]
        self.start = [self.model.new_int_var(0, asked.horizon, f"t{i}") for i in range(count)]
        self.arcs: dict[tuple[int, int], cp_model.IntVar] = {}
        self.once()
        self.circuit()
        self.time()
        self.cool()
        self.one_by_one()
        for a, b in asked.precedence:
            self.model.add(self.start[a] <= self.start[b])

    def once(self) -> None:
        """Each contour is started at one point."""
        for a, b in pairwise(self.asked.first):
            self.model.add_exactly_one(self.chosen[a:b])

    def circuit(self) -> None:
        """The steps form one circuit through the depot, node 0, and the chosen points or all contours."""
        stops, spans = self.asked.stops, self.asked.spans
        places = range(len(stops))
        for v in places:
            for w in places:
                if stops[v] != stops[w] and spans[v][w] is not None:
                    self.arcs[v, w] = self.model.new_bool_var(f"y{v}_{w}")
        self.leave = [self.model.new_bool_var(f"f{v}") for v in places]
        arcs: list[tuple[int, int, cp_model.LiteralT]] = [(v + 1, w + 1, y) for (v, w), y in self.arcs.items()]
        arcs += [(0, v + 1, self.leave[v]) for v in places]
        arcs += [(v + 1, 0, self.model.new_bool_var(f"g{v}")) for v in places]
        if len(stops) == len(self.chosen):
            arcs += [(v + 1, v + 1, ~self.chosen[v]) for v in places]
        self.model.add_circuit(arcs)

    def time(self) -> None:
        """Starts follow each other by work and way, up to the rounding of both."""
        stops = self.asked.stops
        for (v, w), literal in self.arcs.items():
            span = self.asked.spans[v][w]
            assert span is not None
            step = self.start[stops[w]] - self.start[stops[v]]
            self.model.add_linear_constraint(step, *span).only_enforce_if(literal)
        for v, literal in enumerate(self.leave):
            self.model.add(self.start[stops[v]] == 0).only_enforce_if(literal)

    def cool(self) -> None:
        """No contour heats a later start point above the level."""
        for v, j, low, high in self.asked.windows:
            lag = self.start[self.contour_of[v]] - self.start[j]
            if high is None or high > self.asked.horizon:
                self.model.add(lag <= low).only_enforce_if(self.chosen[v])
                continue
            early = self.model.new_bool_var(f"b{v}_{j}")
            self.model.add(lag <= low).only_enforce_if(early, self.chosen[v])
            self.model.add(lag >= high).only_enforce_if(~early, self.chosen[v])

    def one_by_one(self) -> None:
        """Contours are cut one after the other."""
        pairs = zip(self.start, self.asked.works, strict=True)
        intervals = [
            self.model.new_fixed_size_interval_var(start, work, f"i{i}")
            for i, (start, work) in enumerate(pairs)
        ]
        self.model.add_no_overlap(intervals)

    def order(self, solver: cp_model.CpSolver) -> list[int]:
        """Return the points of a solution in order."""
        chosen = [v for v, literal in enumerate(self.chosen) if solver.boolean_value(literal)]
        return sorted(chosen, key=lambda v: solver.value(self.start[self.contour_of[v]]))


def answer(asked: Question, send: Send, stop: threading.Event | None = None) -> None:
    """Send a plan's points if there is one, then the solver's status."""
    built, solver = CoolModel(asked), cp_model.CpSolver()
    solver.parameters.num_workers = asked.workers
    # As in ``cpsat.worker``: probing may lose plans.
    solver.parameters.cp_model_probing_level = 0
    solver.parameters.catch_sigint_signal = False
    solver.parameters.max_memory_in_mb = 3 * asked.memory_mib // 4
    if asked.seconds is not None:
        solver.parameters.max_time_in_seconds = max(0.0, asked.seconds)
    finished = threading.Event()
    if stop is not None:
        threading.Thread(target=stop_when_asked, args=(solver, stop, finished), daemon=True).start()
    status = solver.solve(built.model)
    finished.set()
    if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        send(("plan", built.order(solver)))
    send(("done", solver.status_name(status)))


if __name__ == "__main__":
    serve(answer)
