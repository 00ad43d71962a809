"""Small errors in the checker's rules for free entries."""

from certificate.mutants import Mutant, mutants

NO_MORE = "no_prices_prove_more_than_the_optimum"
REACHED = "prices_reach_the_relaxation"
FORGED = "forged_prices_are_refused"

PERSPECTIVE = [
    *mutants(
        "perspective.py",
        NO_MORE,
        ("2 * sign * w + total - 2 * g", "2 * sign * w - 2 * g"),
        ("// (2 * below)", "// below"),
        ("(u, step, 1)", "(u, step, -1)"),
    ),
    *mutants(
        "perspective.py",
        REACHED,
        ("2 * sign * w + total - 2 * g", "2 * w + total - 2 * g"),
        ("2 * sign * w + total - 2 * g", "2 * sign * w + total"),
        ("least([-g for g in shift])", "least(shift)"),
        ("        rests += most\n", ""),
        ("        rests += most\n", "        rests += most // 2\n"),
        ("costs[edge] += least + most", "costs[edge] += least"),
        ("[-g for g in shift]) // below)", "[-g for g in shift]) // (below // 2))"),
        ("potentials, [], 1)", "[0] * count, [], 1)"),
    ),
    *mutants(
        "perspective.py",
        FORGED,
        ("<= multiplier_scale**2", "<= 2 * multiplier_scale**2"),
        ('problem.metric == "euclidean"', "True"),
        ("count >= 3", "count >= 2"),
        ("len(edges))\n", "None)\n"),
    ),
    Mutant("checker.py", "in FREE_ENTRIES", 'in (*FREE_ENTRIES, "tour")', FORGED),
    Mutant("checker.py", "rules.free_entries == free", "not rules.free_entries or free", FORGED),
    *mutants(
        "regions.py",
        "least_over_a_region_is_rounded_down",
        ("isqrt(square - 1) + 1 if square else 0", "isqrt(square)"),
        ("isqrt(square - 1) + 1 if square else 0", "isqrt(square) + 1"),
        ("min(a * x", "max(a * x"),
        ("(a * x + b * y + c * z) ** 2", "(a * x + b * y + c * z)"),
    ),
    *mutants(
        "problem.py",
        "regions_are_those_of_the_file",
        ("        if ellipsoid is not None:\n            return (ellipsoid[0],), ellipsoid[1]\n", ""),
        ("require(len(points) == 1, f", "require(True, f"),
        ("all(z == height for _, _, z in points), f", "True, f"),
        ("(x, y, height) for x, y in curve", "(x, y, Fraction(0)) for x, y in curve"),
    ),
]
