"""Bounds under heat reach the optimum of all plans and no more; no plan that ``check`` allows is refuted."""

import copy
import importlib
import math
from dataclasses import asdict, replace
from decimal import Decimal, getcontext
from functools import cache
from typing import Any

import numpy as np
import pytest
from oracles.heat import HotPlans, distances, hot_plans
from oracles.heat_plates import STEEL, tied_plate
from oracles.random_plates import random_plate

from certificate.battery import battery
from certificate.samples import document_of
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, check, evaluate

SCALE = 10**9
HAIR = 1000
"""Claims are this far from the optimum, in 1 / SCALE mm or deg C: more than integers are rounded by in all."""
TRAVEL, PEAK = Rules("travel"), Rules("peak")
CLEAR = replace(TRAVEL, clear_rapids=True)


def heat_certificate(
    api: Any, instance: Instance, rules: Rules, bound: int | None, **changes: Any
) -> dict[str, Any]:
    certificate = {
        "format": "cutgap-certificate",
        "version": 1,
        "instance": api.problem_of(document_of(instance)).digest,
        "rules": asdict(rules),
        "scale": SCALE,
        "multiplier_scale": 1,
        "bound": bound,
        "plan": None,
        "proof": {"kind": "heat"},
    }
    return certificate | changes


def holds(api: Any, instance: Instance, rules: Rules, bound: int | None) -> bool:
    """Whether the checker proves a claim, or a plan contradicts it."""
    certificate, document = heat_certificate(api, instance, rules, bound), document_of(instance)
    try:
        verdict = api.verify(certificate, document)
    except api.Refused as refusal:
        if "not excluded" in str(refusal):
            return False
        raise
    speed = api.problem_of(document).v_jump if rules.objective == "makespan" else 1
    assert verdict.bound == (None if bound is None else bound / api.problem.Fraction(SCALE) / speed)
    return True


@cache
def plates() -> tuple[tuple[Instance, Rules, HotPlans], ...]:
    """Plates full of ties, with and without homes; polygons with clear rapids; and all their plans."""
    found = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        instance = tied_plate(rng, int(rng.integers(1, 5)), points=int(rng.integers(1, 4)))
        found.append((instance, TRAVEL, hot_plans(instance)))
    for seed in range(4):
        instance = random_plate(np.random.default_rng(seed), 4, entries=2)
        found.append((instance, CLEAR, hot_plans(instance, clear_rapids=True)))
    return tuple(found)


def is_tight(api: Any, instance: Instance, rules: Rules, optimum: float) -> bool:
    """Whether a hair less than the optimum is proved, and a hair more is not."""
    claims = math.floor(optimum * SCALE) - HAIR, math.ceil(optimum * SCALE) + HAIR
    return [holds(api, instance, rules, claim) for claim in claims] == [True, False]


@battery
def peaks_reach_the_optimum_and_no_more(api: Any) -> None:
    tried = 0
    for instance, rules, plans in plates():
        best = plans.least_peak()
        if best is not None and math.isfinite(best.peak):
            assert is_tight(api, instance, replace(rules, objective="peak"), best.peak)
            tried += 1
    assert tried >= 10


@battery
def travel_under_caps_reaches_the_optimum_and_no_more(api: Any) -> None:
    tried = 0
    for number, (instance, rules, plans) in enumerate(plates()):
        peaks = sorted({plan.peak for plan in plans.plans if math.isfinite(plan.peak)})
        for cap in peaks[:: max(1, len(peaks) // 2)]:
            best = plans.least_travel(cap)
            assert best is not None
            assert is_tight(api, instance, replace(rules, temperature_cap=cap), best.travel)
            tried += 1
        if number % 3 == 0 and plans.plans:
            assert is_tight(api, instance, rules, plans.least_travel().travel)
    assert tried >= 20


@battery
def caps_below_all_peaks_have_no_plan(api: Any) -> None:
    for instance, rules, plans in plates():
        peak = min((plan.peak for plan in plans.plans), default=math.inf)
        if math.isfinite(peak):
            below = replace(rules, temperature_cap=peak - 1e-6)
            assert holds(api, instance, below, None)
            assert holds(api, instance, replace(below, objective="peak"), None)
            assert holds(api, instance, below, 10**20)
            assert holds(api, instance, replace(below, objective="peak"), 10**20)
            assert not holds(api, instance, replace(rules, temperature_cap=peak), None)


@battery
def plans_that_check_allows_are_not_refuted(api: Any) -> None:
    """The cap is below the plan's own peak, by most of the slack that ``check`` grants."""
    allowed = 0
    for number, (instance, rules, plans) in enumerate(plates()):
        rng = np.random.default_rng(number)
        for each in rng.permutation(len(plans.plans))[:4]:
            plan = plans.plans[each].plan
            figures = evaluate(instance, plan)
            if math.isinf(figures.peak_temperature_c):
                continue
            slack = 0.98e-9 * max(1.0, figures.peak_temperature_c - STEEL.ambient_c)
            capped = replace(rules, temperature_cap=figures.peak_temperature_c - slack)
            if check(instance, capped, plan):
                continue
            allowed += 1
            assert not holds(api, instance, capped, None)
            assert not holds(api, instance, capped, math.ceil(figures.total_travel_mm * SCALE) + HAIR)
            peak = math.ceil(figures.peak_temperature_c * SCALE) + HAIR
            assert not holds(api, instance, replace(rules, objective="peak"), peak)
    assert allowed >= 30


def excludes(api: Any, instance: Instance, rules: Rules, plan: Plan) -> bool | None:
    """Whether the checker proves that there is no plan; ``None`` where ``check`` does not allow this one."""
    return None if check(instance, rules, plan) else holds(api, instance, rules, None)


@battery
def rapids_cross_what_they_cross_in_doubles(api: Any) -> None:
    """In decimals the second rapid touches a corner; in doubles some miss it by a hair."""
    answers = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        start, step = rng.integers(0, 50, 2), rng.integers(1, 20, 2)
        aside = np.array([-step[1], step[0]])
        corners = [
            (start, start - step, start - step + aside),
            (start + 3 * step, start + 4 * step, start + 4 * step + aside),
            (start + step, start + 2 * (step + aside), start + step + 3 * aside),
        ]
        contours = tuple(
            Contour(name, [[*(curve[0] / 10), 0]], 0.0, geometry=np.array(curve) / 10)
            for name, curve in zip("abc", corners, strict=True)
        )
        instance = Instance("touch", contours, (Head("h"),), precedence=((2, 0), (0, 1)), material=STEEL)
        answers.append(excludes(api, instance, CLEAR, Plan.of_contours([[2, 0, 1]])))
    assert answers.count(None) > 5
    assert answers.count(False) > 5
    assert True not in answers


@battery
def times_far_from_the_origin_are_uncertain(api: Any) -> None:
    """Doubles know a place a kilometre off by 1e-10 mm, so a way of a micrometre by less than a millionth."""
    answers = []
    for k in range(40):
        place = round(1e6 + 0.001 * (1 + k) + 1e-4 * k, 6)
        curves = [[1e6, 0], [place, 0], [1e6 + 2, 2]], [[place, 0], [1e6 + 1, 3], [place, 0.5]]
        contours = tuple(
            Contour(name, [[*curve[0], 0]], 0.0, geometry=curve)
            for name, curve in zip("ab", curves, strict=True)
        )
        slow = Machine(v_jump=0.01, v_cut=40.0, t_aux=0.0)
        instance = Instance("far", contours, (Head("h"),), slow, precedence=((0, 1),), material=STEEL)
        plan = Plan.of_contours([[0, 1]])
        capped = replace(TRAVEL, temperature_cap=evaluate(instance, plan).peak_temperature_c)
        answers.append(excludes(api, instance, capped, plan))
        below = replace(TRAVEL, temperature_cap=capped.temperature_cap * (1 - 1e-3))
        assert holds(api, instance, below, None)
    assert answers == [False] * 40


@battery
def a_cap_is_broken_by_more_than_check_grants(api: Any) -> None:
    heat, problems = importlib.import_module(f"{api.__name__}.heat"), plates()
    problem = api.problem_of(document_of(problems[0][0]))
    for cap in (20.0, 20.5, 21.0, 320.0, 1e6, -5.0):
        rules = api.rules_of(asdict(replace(TRAVEL, temperature_cap=cap)), problem)
        rise = cap - STEEL.ambient_c
        unit = api.problem.Fraction(heat.KELVIN)
        beyond = float(heat.hot_rise(problem, rules) / unit - api.problem.Fraction(cap) + 20)
        assert 1.5e-9 * max(1.0, abs(rise)) <= beyond <= 3e-9 * max(1.0, abs(rise))


@battery
def makespans_under_caps_count_the_work(api: Any) -> None:
    for instance, rules, plans in plates()[10:13]:
        peak = plans.least_peak().peak
        capped = replace(rules, objective="makespan", temperature_cap=peak)
        work = instance.machine.v_jump * float(instance.service_times.sum())
        assert is_tight(api, instance, capped, plans.least_travel(peak).travel + work)


@battery
def warmth_is_rounded_down_by_little(api: Any) -> None:
    """The kernel against decimals of 50 digits, over lags from a microsecond to a day."""
    getcontext().prec = 50
    warmth = importlib.import_module(f"{api.__name__}.warmth")
    for instance, _, _ in plates():
        table, kernel = distances(instance), warmth.Warmth(api.problem_of(document_of(instance)))
        points = [(i, e) for i, each in enumerate(instance.contours) for e in range(len(each.entry_points))]
        for point, (i, e) in enumerate(points):
            for j in range(len(instance.contours)):
                for exponent in range(-6, 6, 2):
                    lag = int(Decimal(10) ** exponent * warmth.SECOND)
                    true = exact(instance, table[i, e, j], Decimal(lag) / warmth.SECOND)
                    found = Decimal(kernel.at(point, j, lag)) / warmth.KELVIN
                    assert found <= true
                    # At a distance of 0 or nearly, the margin of lengths counts by itself.
                    assert found >= true * (1 - Decimal(10) ** -7) - Decimal(10) ** -9
                assert kernel.at(point, j, 0) == kernel.at(point, j, -5) == 0


def exact(instance: Instance, distance_mm: float, lag: Decimal) -> Decimal:
    """T(L, t) for the distance a hair longer than the float, K."""
    material = instance.material
    pi = Decimal("3.14159265358979323846264338327950288419716939937511")
    conductivity = Decimal(material.conductivity_w_per_m_k)
    capacity = Decimal(material.specific_heat_j_per_kg_k) * Decimal(material.density_kg_per_m3)
    line = Decimal(material.power_w) / (
        Decimal(instance.machine.v_cut) / 1000 * Decimal(material.thickness_mm) / 1000
    )
    distance = (Decimal(distance_mm) + Decimal("5e-12")) / 1000
    spread = (-(distance**2) * capacity / (4 * conductivity * lag)).exp()
    return line * spread / (4 * pi * conductivity * capacity * lag).sqrt()


@battery
def least_warmth_of_a_time_is_the_least(api: Any) -> None:
    warmth = importlib.import_module(f"{api.__name__}.warmth")
    kernel = warmth.Warmth(api.problem_of(document_of(plates()[-1][0])))
    rng = np.random.default_rng(0)
    for _ in range(200):
        point, contour = (int(rng.integers(len(side))) for side in (kernel.exponents, kernel.exponents[0]))
        around = max(0, kernel.rising[point][contour]) / warmth.SECOND
        ends = sorted((around + 0.01) * np.exp(rng.normal(size=2)))
        soon, late = (int(end * warmth.SECOND) for end in ends)
        times = np.linspace(soon, late, 20)
        least = min(kernel.at(point, contour, int(time)) for time in times)
        # Rounding moves neighbouring times against each other.
        assert kernel.least(point, contour, soon, late) <= least * (1 + 1e-9) + 2
        assert kernel.least(point, contour, soon, late) >= least * (1 - 1e-6) - 2


FORGED: list[tuple[str, Any, str]] = [
    ("a hint", {"proof": {"kind": "heat", "prices": [0]}}, "unknown field"),
    ("no kind", {"proof": {}}, "no kind"),
    ("a list of kinds", {"proof": {"kind": ["heat"]}}, "no kind"),
    ("a kind without heat", {"proof": {"kind": "contour-dp", "walks": []}}, "no kind for peaks"),
    ("compact", {"proof": {"kind": "compact", "formulation": "mtz", "multipliers": []}}, "no kind for peaks"),
    ("a plan", {"plan": [[["c0", 0], ["c1", 0], ["c2", 0]]]}, "temperatures are not checked"),
    ("a bound that is none", {"bound": 1.5}, "whole number"),
    ("no scale", {"scale": 0}, "at least 1"),
]


@battery
def forged_heat_is_refused(api: Any) -> None:
    instance = random_plate(np.random.default_rng(0), 3, entries=2)
    document, good = document_of(instance), heat_certificate(api, instance, PEAK, 20 * SCALE)
    assert api.verify(good, document).unit == "deg C"
    for _, changes, message in FORGED:
        with pytest.raises(api.Refused, match=message):
            api.verify(good | changes, document)
    for field in ("proof", "bound", "rules"):
        with pytest.raises(api.Refused, match="missing"):
            api.verify({name: value for name, value in good.items() if name != field}, document)
    for field in ("conductivity_w_per_m_k", "density_kg_per_m3", "thickness_mm", "power_w", "ambient_c"):
        other = copy.deepcopy(document)
        other["material"][field] += 1
        with pytest.raises(api.Refused, match="another instance"):
            api.verify(good, other)
    with pytest.raises(api.Refused, match="other rules"):
        api.verify(good, document, asdict(replace(PEAK, clear_rapids=True)))
    with pytest.raises(api.Refused, match="too many steps"):
        api.verify(good | {"bound": 25 * SCALE}, document, steps=10)
    bare = replace(instance, material=None)
    with pytest.raises(api.Refused, match="heat: the instance has no material"):
        api.verify(heat_certificate(api, bare, TRAVEL, 0), document_of(bare))
    for changed, message in (
        (bare, "speak of heat"),
        (replace(instance, heads=(Head("l"), Head("r"))), "one head"),
        (
            replace(instance, contours=tuple(replace(c, geometry=None) for c in instance.contours)),
            "no geometry",
        ),
    ):
        with pytest.raises(api.Refused, match=message):
            api.verify(heat_certificate(api, changed, PEAK, 25 * SCALE), document_of(changed))
    cold = document | {"material": document["material"] | {"power_w": 0}}
    with pytest.raises(api.Refused, match="above 0"):
        api.verify(good, cold)


@battery
def every_temperature_is_paid_for(api: Any) -> None:
    """Else a proof of unknown origin could take any time."""
    heat, warmth = (importlib.import_module(f"{api.__name__}.{name}") for name in ("heat", "warmth"))
    (instance, rules, plans), steps, calls = plates()[10], 10**12, 0
    least = warmth.Warmth.least

    def counted(*arguments: Any) -> int:
        nonlocal calls
        calls += 1
        return int(least(*arguments))

    problem, budget = api.problem_of(document_of(instance)), api.proof.Budget(steps)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(warmth.Warmth, "least", counted)
        # So dear that all else does not count.
        patch.setattr(heat, "KERNEL_STEPS", 10**6)
        hot = int((plans.least_peak().peak - instance.material.ambient_c - 1e-6) * heat.KELVIN)
        heat.search_heat(problem, api.rules_of(asdict(rules), problem), SCALE, None, hot, budget)
    assert calls > 100
    assert steps - budget.steps >= 10**6 * calls


@battery
def large_plates_are_refused_before_the_search(api: Any) -> None:
    rng = np.random.default_rng(0)
    many, full = tied_plate(rng, 17, points=1), tied_plate(rng, 14, points=4)
    fine = tied_plate(rng, 2, points=1, home=False, metric="euclidean")
    corners = np.tile(fine.contours[0].geometry, (10, 1))
    long = replace(fine, contours=tuple(replace(each, geometry=corners) for each in fine.contours))
    crowd = np.column_stack([np.tile(corners, (13, 1)), np.zeros(520)])
    crowded = replace(fine, contours=tuple(replace(each, entry_points=crowd) for each in fine.contours))
    # Two contours with four corners, or 40, in steps that are enough for the former.
    for each, message in ((fine, "not excluded"), (long, "too many steps")):
        with pytest.raises(api.Refused, match=message):
            api.verify(heat_certificate(api, each, PEAK, 10**10 * SCALE), document_of(each), steps=20_000)
    beyond = replace(fine, material=replace(STEEL, power_w=1e31))
    with pytest.raises(api.Refused, match="beyond 1e30"):
        api.verify(heat_certificate(api, beyond, PEAK, 30 * SCALE), document_of(beyond))
    for instance, message in (
        (many, "more than 16"),
        (full, "more points and contours"),
        (crowded, "more points and contours"),
    ):
        with pytest.raises(api.Refused, match=message):
            api.verify(heat_certificate(api, instance, PEAK, 30 * SCALE), document_of(instance), steps=1)
