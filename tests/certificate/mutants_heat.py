"""Small errors in the checker's search of plates under heat."""

from certificate.mutants import Mutant, mutants

PEAKS = "peaks_reach_the_optimum_and_no_more"
CAPS = "travel_under_caps_reaches_the_optimum_and_no_more"
NONE = "caps_below_all_peaks_have_no_plan"
ALLOWED = "plans_that_check_allows_are_not_refuted"
ROUNDED = "warmth_is_rounded_down_by_little"
FORGED = "forged_heat_is_refused"
LARGE = "large_plates_are_refused_before_the_search"
SLACK = "a_cap_is_broken_by_more_than_check_grants"
LEAST = "least_warmth_of_a_time_is_the_least"

HEAT = [
    *mutants(
        "heat.py",
        PEAKS,
        ("- problem.material.ambient) * KELVIN)", ") * KELVIN)"),
        ("self._rise(w, begun, ends) < self.hot", "self._rise(w, begun, ends) < 0"),
        ("begun = now + self.way[v][w]", "begun = now"),
        ("(b, begun + self.work[b])", "(b, begun)"),
        ("        for j, done in reversed(ends):", "        for j, done in ends[-1:]:"),
        ("begun - done - self.early", "done - self.early"),
        ("barred[done | 1 << a] = best >= hot", "barred[done | 1 << a] = True"),
        ("barred[1 << a] = rise[0] >= hot", "barred[1 << a] = True"),
        ("for w in range(len(start)) if", "for w in range(1) if"),
    ),
    *mutants(
        "heat.py",
        CAPS,
        ("further + self.onward[after][w] < self.dear", "further + self.onward[after][w] < self.dear - 10**7"),
        ("further, after = travel + self.cost[v][w]", "further, after = travel + 2 * self.cost[v][w]"),
        ("self.onward[self.full] = end", "self.onward[self.full] = [2 * each for each in end]"),
        ("cut | 1 << b][w]\n", "cut | 1 << b][w] + 1000\n"),
        ("for first in nodes:", "for first in nodes[:1]:"),
        ("return curves.crossed(v, w) if", "return curves.crossed(v, w) | 1 << a if"),
        ("return curves.crossed(v, w) if", "return 0 if"),
        (
            "self.dear, self.hot = budget, NEVER if dear is None else dear, hot",
            "self.dear, self.hot = budget, NEVER if dear is None else dear, 0",
        ),
    ),
    *mutants(
        "heat.py",
        NONE,
        ("hot = claimed if hot is None else min(hot, claimed)", "hot = claimed"),
        ("        # Where travel has no limit", "        self.dear = 0\n        # Where travel has no limit"),
        ("    elif bound is not None:\n        work", "    else:\n        bound = 0\n        work"),
        (
            "return floor((rise + slack) * KELVIN) + 1",
            "return floor((rise - slack - Fraction(1, 10**5)) * KELVIN) + 1",
        ),
        (
            "return floor((rise + slack) * KELVIN) + 1",
            "return floor((rise + slack + Fraction(1, 10**5)) * KELVIN) + 1",
        ),
    ),
    *mutants(
        "heat.py",
        ALLOWED,
        ("return floor((rise + slack) * KELVIN) + 1", "return floor(rise * KELVIN) + 1"),
        ("SLACK = Fraction(2, 10**9)", "SLACK = Fraction(1, 2 * 10**9)"),
    ),
    *mutants(
        "heat.py",
        SLACK,
        ("SLACK = Fraction(2, 10**9)", "SLACK = Fraction(1, 10**9)"),
        ("max(Fraction(1), abs(rise))", "abs(rise)"),
        ("max(Fraction(1), abs(rise))", "Fraction(1)"),
    ),
    Mutant(
        "heat.py",
        "(work if rules.objective",
        "(0 * work if rules.objective",
        "makespans_under_caps_count_the_work",
    ),
    *mutants(
        "heat.py",
        FORGED,
        ('    fields(proof, "proof", "kind")\n', ""),
        ("require(len(problem.homes) == 1", "require(True"),
        ('require(problem.material is not None, "heat: the instance has no material")', "pass"),
    ),
    *mutants(
        "heat.py",
        "every_temperature_is_paid_for",
        ("self.budget.spend(terms * KERNEL_STEPS)", "pass"),
        ("self.budget.spend(KERNEL_STEPS * len(ends))", "pass"),
    ),
    *mutants(
        "heat.py",
        LARGE,
        ("require(len(problem.ids) <= MOST_CONTOURS", "require(True"),
        ("points * points << self.count <= MOST_CELLS", "True"),
        ("points <= MOST_POINTS and ", ""),
        ("budget.spend(DISTANCE_STEPS * points", "print(points"),
    ),
    Mutant("heat.py", "out + _farthest(problem)", "out", "times_far_from_the_origin_are_uncertain"),
    Mutant("plane.py", "float(value)", "value", "rapids_cross_what_they_cross_in_doubles"),
    Mutant("warmth.py", "require(all(ORDINARY", "require(True or all(ORDINARY", LARGE),
    *mutants(
        "warmth.py",
        ROUNDED,
        ("range(6)", "range(1)"),
        ("greatest_pi()", "3"),
        ("// lag + 1", "// lag"),
        ("(isqrt(lag << 40) + 1)", "isqrt(lag << 38)"),
        ("x >> 30 & 1023", "x >> 31 & 1023"),
        ("x >> 20 & 1023", "x >> 21 & 1023"),
        ("((1 << EXPONENT) - (x & 0xFFFFF))", "(1 << EXPONENT)"),
        ("(4 * diffusivity)", "(8 * diffusivity)"),
        ("if i >= LOWEST:", "if i >= 1:"),
        ("if lag <= 0:", "if lag < 0:"),
        ("isqrt(int(square * unit * unit)) + margin", "isqrt(int(square * unit * unit)) - margin"),
        ("pairwise([*corners, corners[0]])", "pairwise(corners)"),
        ("material.thickness)", "material.thickness * 1000)"),
    ),
    *mutants(
        "warmth.py",
        PEAKS,
        ("        if point in corners:\n            return Fraction(0)\n", ""),
        ("if each > 0 else FALLING", "if True else FALLING"),
    ),
    *mutants(
        "warmth.py",
        LEAST,
        ("if latest <= rising:", "if soonest <= rising:"),
        ("if soonest > rising:", "if latest > rising:"),
        ("return min(self.at(point, contour, soonest)", "return max(self.at(point, contour, soonest)"),
    ),
    *mutants(
        "sheet.py",
        FORGED,
        ("require(min(conductivity, heat, density, thickness, power) > 0", "require(True"),
        ("heat * density", "heat"),
        ("ambient = number(table.get", "ambient = 0 * number(table.get"),
    ),
    Mutant("problem.py", ", *(material or ())])", "])", FORGED),
    Mutant("checker.py", 'rules.objective != "peak" or kind == "heat"', "True", FORGED),
    Mutant("rules.py", "problem.material is not None or not heated", "True", FORGED),
    Mutant("plan.py", 'cap is None and rules.objective != "peak"', "True", FORGED),
]
