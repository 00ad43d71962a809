"""What the objective of two heads is at least, from the lengths of their tours; see ``docs/two-heads.md``."""

from cutgap.instances import Machine, Rules


def objective_bound(
    machine: Machine,
    rules: Rules,
    lengths: tuple[float, float],
    services_s: tuple[float, float],
    floating_s: float = 0.0,
) -> float:
    """Return a lower bound on the objective when tours have at least these lengths.

    For makespan, and for a weight of at most ``v_jump`` without a limit on imbalance, it is the value of tours
    of just these lengths.

    Parameters
    ----------
    lengths
        Least travel of each head, mm.
    services_s
        Work of each head, s.
    floating_s
        Work that may still go to either head, s.
    """
    speed = machine.v_jump
    t_1, t_2 = (length / speed + s for length, s in zip(lengths, services_s, strict=True))
    if rules.objective == "makespan":
        return max(t_1, t_2, (t_1 + t_2 + floating_s) / 2)
    apart = max(0.0, abs(t_1 - t_2) - floating_s)
    kept = apart if rules.balance is None else min(apart, rules.balance)
    return sum(lengths) + min(rules.weight, speed) * kept + speed * (apart - kept)
