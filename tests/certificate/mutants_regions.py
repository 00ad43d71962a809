"""Small errors in the checker's rules for tours through regions."""

from certificate.mutants import Mutant, mutants

BOUNDS = "bounds_of_orders_hold_and_are_tight"
PROOFS = "proofs_through_regions_reach_the_optimum"
FORGED = "forged_proofs_through_regions_are_refused"
PLANS = "points_of_plans_are_moved_into_their_regions"

REGIONS: list[Mutant] = [
    *mutants(
        "regions.py",
        BOUNDS,
        ("u[k - 1], u[k]", "u[k], u[k - 1]"),
        ("u[k - 1], u[k]", "u[k - 2], u[k]"),
        ("total -= root", "total += root"),
        ("FINE * FINE * sum", "FINE * sum"),
        ("FINE * min(", "FINE * max("),
        ("x - a, y - b, z - c", "x - a, y - b, z"),
        ("** 2 for d, e, f in shape.axes", "** 2 for d, e, f in shape.axes[:1]"),
    ),
    *mutants(
        "regions.py",
        FORGED,
        ("x * x + y * y + z * z <= scale * scale", "True"),
        ("bound >= length", "True"),
        ("require(waiting == []", "require(True"),
        ("require(region not in order", "require(True"),
        ("len(set(root)) == len(root)", "True"),
        ("(2 if regions.before else 3)", "3"),
        ("<= (2 if regions.before else 3)", "<= 4"),
        ("root[0] == regions.home", "True"),
        ("each < len(regions.shapes) for", "True for"),
        ("scale >= 1 and len(numbers) == axes * len(order)", "True"),
    ),
    *mutants(
        "regions.py",
        PROOFS,
        ("max(earlier, default=0)", "0"),
        ("max(earlier, default=0)", "len(order) - 1"),
        ("default=len(order))", "default=len(order) - 1)"),
        ("min(later, default=len(order))", "len(order)"),
    ),
    *mutants(
        "free_plan.py",
        PLANS,
        ("away <= most * most", "True"),
        ("if square > 1:", "if False:"),
        ("min(max(share, Fraction(0)), Fraction(1))", "share"),
        ("points[contour] = into(problem.region(contour), place, name)", "points[contour] = place"),
        ("_turn(a, b, (x, y)) >= 0", "True"),
        ("return x, y, height", "return place"),
    ),
    *mutants(
        "checker.py",
        FORGED,
        ("require(rules.free_entries == free,", "require(True,"),
    ),
    *mutants("checker.py", PROOFS, ("bound - (work if", "bound - (0 if")),
    *mutants(
        "plan.py",
        FORGED,
        ('not (rules.neighbours_only or rules.clear_rapids), "plan: free', 'True, "plan: free'),
    ),
]
