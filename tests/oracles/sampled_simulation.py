"""Where the heads are at any time, by walking the plan phase by phase; their separation by fine sampling."""

from collections.abc import Sequence

from oracles.problem import Problem, Tour


def head_x(problem: Problem, head: int, tour: Tour, time: float, chebyshev: bool) -> float:
    """Return x of a head (mm) at ``time`` (s) after all heads start.

    It stands while it cuts, and before and after its work. On a rapid x moves evenly, or, when the axes
    move at once (``chebyshev``), at full speed until it is there.
    """
    home, home_node = problem.homes[head], problem.home_node(head)
    if not tour:
        if home is None:
            raise ValueError("a head without home and work is nowhere")
        return home[0]
    stops = [(problem.node(*visit[:2]), problem.entries[visit[0]][visit[1]][0], visit[0]) for visit in tour]
    legs: list[tuple[int, float, int | None]]
    if home is None or home_node is None:
        node, x, contour = stops[0]
        time -= problem.work([contour])
        legs = [*stops[1:], (node, x, None)]
    else:
        node, x = home_node, home[0]
        legs = [*stops, (node, x, None)]
    for target, target_x, work in legs:
        if time <= 0:
            return x
        duration = problem.lengths[node][target] / problem.v_jump
        if time < duration:
            if chebyshev:
                step = min(time * problem.v_jump, abs(target_x - x))
                return x + step if target_x > x else x - step
            return x + (target_x - x) * time / duration
        time -= duration
        node, x = target, target_x
        if work is not None:
            time -= problem.work([work])
    return x


def sampled_separation(
    problem: Problem, tours: tuple[Tour, ...], times: Sequence[float], chebyshev: bool = False
) -> float:
    """Return the smallest x distance of neighbouring heads at the given times: at least the true minimum."""
    return min(
        head_x(problem, head + 1, tours[head + 1], time, chebyshev)
        - head_x(problem, head, tours[head], time, chebyshev)
        for time in times
        for head in range(len(tours) - 1)
    )
