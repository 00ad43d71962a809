"""Small errors in the checker's rules for tours through one entry point of each contour."""

from certificate.mutants import Mutant, mutants

ROWS = "rows_of_generalized_tours_hold_and_are_tight"
COMBS = "combs_of_generalized_tours_hold_and_are_tight"
FORGED = "forgeries_are_refused"
STEPS = "lengths_of_generalized_tours_go_in_steps"

GENERALIZED = [
    *mutants(
        "generalized.py",
        ROWS,
        ("1 if len(self.contours) > 2 else 2, 0", "1, 0"),
        ("Row(True, 1, (), ((1, self", "Row(True, 2, (), ((1, self"),
        ("((-2, [v]),)", "((-1, [v]),)"),
        ("self._row(sets, -1,", "self._row(sets, 0,"),
        ("self._row(sets, -1,", "self._row(sets, -2,"),
        ("rhs += 1", "rhs += 2"),
        ("rhs += 1", "pass"),
        ("terms.append((-1, sorted", "terms.append((-2, sorted"),
        ("terms.append((-1, sorted", "terms.append((0, sorted"),
        ("terms.append((-1, array", "terms.append((-2, array"),
        ("terms.append((-1, array", "terms.append((1, array"),
        ("(outside, k)", "(inside, k)"),
        ("u * (u + 1) // 2", "u * (u - 1) // 2"),
    ),
    *mutants(
        "generalized.py",
        COMBS,
        ("(1 - teeth) // 2", "(3 - teeth) // 2"),
        ("(1 - teeth) // 2", "-teeth"),
        ("(set(tooth) - handle, k)", "(set(tooth), k)"),
        ("(set(tooth) & handle, h)", "(set(tooth), h)"),
    ),
    *mutants(
        "generalized.py",
        FORGED,
        ("any(part.issuperset(nodes) for", "any(part or nodes for"),
        (
            "< len(self.contours)\n                require(known",
            "<= len(self.contours)\n                require(known",
        ),
        ("0 <= v < self.count:\n                return v", "0 <= v <= self.count:\n                return v"),
        ("0 <= u < v < self.count", "0 <= v < self.count"),
    ),
    Mutant("generalized.py", "gcd(self.step, cost)", "max(self.step, cost)", STEPS),
    Mutant("generalized.py", "gcd(self.step, cost)", "1", STEPS),
    *mutants(
        "checker.py",
        STEPS,
        ("(length - 1) // relaxation.step", "(length - 2 * relaxation.step) // relaxation.step"),
        ("(length - 1) // relaxation.step", "(length - relaxation.step) // relaxation.step"),
        ("(length - 1) // relaxation.step", "length // relaxation.step"),
    ),
    *mutants(
        "checker.py",
        FORGED,
        ("require(length <= 0", "require(True"),
        ('require(problem.is_symmetric(), "gtsp', 'require(True, "gtsp'),
    ),
]
