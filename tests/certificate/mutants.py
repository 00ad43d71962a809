"""Small errors put into a copy of the checker, each with the check of the battery that must notice it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutant:
    """Replace ``old`` (all of it must be there) by ``new`` in a file; ``killer`` is a check of the battery."""

    file: str
    old: str
    new: str
    killer: str


def mutants(file: str, killer: str, *pairs: tuple[str, str]) -> list[Mutant]:
    return [Mutant(file, old, new, killer) for old, new in pairs]


STRONG = "the_strongest_split_proof_proves_no_more_than_the_optimum"
REACHED = "the_strongest_split_proof_reaches_the_optimum"

MUTANTS = [
    # problem.py
    *mutants(
        "problem.py",
        "lengths_are_floors",
        ("isqrt(square * over // under)", "isqrt(square * over // under) + 1"),
        ("isqrt(square * over)", "isqrt(square * over + 2 * over)"),
        ("max(abs(x - a), abs(y - b), abs(z - c))", "max(abs(x - a), abs(y - b))"),
        ("here[other] * scale // below", "-(-here[other] * scale // below)"),
    ),
    *mutants(
        "problem.py",
        "hashes_tell_problems_apart",
        ("_digest([speeds, ", "_digest([speeds[:2], "),
        ("metric, heads, contours", "metric, contours"),
        ("heads, contours, matrix", "heads, matrix"),
        ("matrix, located])", "located])"),
        ("Fraction(0) if i == j else number", "number"),
    ),
    *mutants(
        "problem.py",
        "forgeries_are_refused",
        ("len(points) == 1,", "len(points) >= 1,"),
        ('require(not table.get("precedence")', "require(True"),
        ("if any(row != column", "if all(row != column"),
        ("len(set(names)) == len(names)", "len(set(names)) <= len(names)"),
        ("len(heads) in (1, 2)", "len(heads) >= 1"),
        ("speeds[0] > 0", "speeds[0] >= 0"),
    ),
    *mutants(
        "problem.py",
        STRONG,
        ('if self.metric != "matrix":\n            return True', "return True"),
        ("length <= min(map(add, row, other))", "length <= max(map(add, row, other))"),
    ),
    # relaxation.py
    *mutants(
        "relaxation.py",
        "wrong_signs_are_refused",
        ("row.equality or multiplier >= 0", "True"),
        ("require(reduced[variable] >= 0", "require(True"),
    ),
    *mutants(
        "relaxation.py",
        "no_multipliers_prove_too_much",
        ("r * low if r >= 0 else r * high", "r * low"),
        ("value += multiplier * row.rhs", "value += 2 * multiplier * row.rhs"),
        ("cost - potentials[tail] - potentials[head]", "cost - potentials[tail]"),
        ("reduced[variable] -= change", "reduced[variable] += change"),
        ("change = multiplier * coefficient", "change = multiplier"),
    ),
    *mutants(
        "relaxation.py",
        "rows_of_a_tour_hold_and_are_tight",
        ("(-2, variables) for", "(-1, variables) for"),
        ("3 * teeth + 1", "3 * teeth + 2"),
        ("3 * teeth + 1", "3 * teeth"),
        ("return members, 2", "return members, 3"),
        ("Row(True, 2, ((v, 1),))", "Row(True, 2, ((v, 2),))"),
        ("Row(False, 1, ()", "Row(False, 2, ()"),
        ("v) for v in self.leftmost", "v) for v in self.leftmost[1:]"),
    ),
    Mutant("relaxation.py", "and teeth % 2 == 1", "", "combs_need_an_odd_number_of_teeth"),
    *mutants(
        "relaxation.py",
        "forgeries_are_refused",
        ("teeth >= 3 and", ""),
        ("bool(tooth & handle) and bool(tooth - handle)", "bool(tooth & handle)"),
        ("bool(tooth & handle) and bool(tooth - handle)", "bool(tooth - handle)"),
        ("not tooth & seen", "True"),
        ("len(members) > 1 or len(members[0]) < self.count", "True"),
        ("each != []", "True"),
        ("len(set(each)) == len(each)", "True"),
        ("0 <= v < count for v", "v < count for v"),
        ('case ["via"] if self.leftmost:', 'case ["via"]:'),
    ),
    # two_heads.py
    *mutants(
        "two_heads.py",
        "rows_of_two_heads_hold_and_are_tight",
        ("rhs=row.rhs - coefficient", "rhs=row.rhs + coefficient"),
        ("rhs=row.rhs - coefficient), -coefficient", "rhs=row.rhs - coefficient), coefficient"),
        ("if head == 1:\n            row", "if head == 0:\n            row"),
        ("head, -2, i)", "head, -3, i)"),
        ("Row(True, 2, legs) if self.e is None else", "Row(True, 2, legs) if True else"),
        ("2 if u == -1 else 1", "1"),
        ("self.work = [floor(", "self.work = [1 + floor("),
        ("(first - second) * work", "(first + second) * work"),
        ("rhs - second * sum(self.work)", "rhs"),
        ("factor * length, [offset", "length, [offset"),
        ("head == 0 else 0, -1 if", "head == 0 else 0, 1 if"),
        ("apart > 0)", "apart < 0)"),
        ("((1, [i]), (-1, [j]))", "((-1, [i]), (1, [j]))"),
        ("self.problem.xs[j] <= self.problem.xs[i]", "self.problem.xs[j] < self.problem.xs[i]"),
        ("self.factor = price.denominator", "self.factor = 1"),
        ("for head in (0, 1):\n            more", "for head in (0,):\n            more"),
    ),
    *mutants(
        "two_heads.py",
        "rows_of_times_leave_room_for_floors",
        ("self.slack = 2 * self.count + 1", "self.slack = 0"),
        ("self._times(-sign, sign, -self.slack, self.d)", "self._times(-sign, sign, self.slack, self.d)"),
        ("-floor(limit + self.slack)", "-floor(limit)"),
        ("-floor(limit + self.slack)", "-floor(self.slack)"),
    ),
    *mutants(
        "two_heads.py",
        "contours_at_the_gap_may_be_divided",
        ("abs(apart) < (self", "abs(apart) <= (self"),
        ("i != j and (together or apart > 0)", "True"),
    ),
    *mutants(
        "two_heads.py",
        "forgeries_are_refused",
        ("len(members) == 1 and i in members[0]", "len(members) == 1"),
        ("u < v and i in (u, v)", "u < v"),
        ("self.rules.non_overlap is not None", "True"),
        ("require(self.rules.via_points", "require(True"),
        ("len(arguments) == len(kinds)", "True"),
        ("and argument in allowed", ""),
    ),
    # proof.py
    *mutants(
        "proof.py",
        "forgeries_are_refused",
        ("require(not reached[index]", "require(True"),
        ("index < child < len(tree)", "child < len(tree)"),
        ("index < child < len(tree)", "index <= child < len(tree)"),
        ("require(all(reached)", "require(True"),
        ("trail.undo(length)", "pass"),
        ("max(low, at + 1)", "max(low, at + 2)"),
        ("min(high, at))", "min(high, at - 1))"),
        ("trail.crossed > 0", "trail.crossed >= 0"),
        ("value >= target,", "True,"),
        ('integer(row, "row", least=0)', 'integer(row, "row")'),
    ),
    *mutants(
        "proof.py",
        "leaves_count_to_the_last_unit",
        ("value >= target,", "value >= target - relaxation.multiplier_scale,"),
        ("value >= target,", "value > target + relaxation.multiplier_scale,"),
    ),
    *mutants(
        "proof.py",
        "fixing_keeps_cheaper_tours",
        ("value + abs(r) >= target", "value + 2 * abs(r) >= target"),
        ("(low, low) if r > 0", "(low, low) if r < 0"),
        ("value + abs(r) >= target", "value + r >= target"),
    ),
    *mutants(
        "proof.py",
        "one_trees_are_minimal",
        ("2 * sum(potentials)", "sum(potentials)"),
        ("min(firsts or at_zero,", "min(at_zero,"),
        ("at_zero.pop(first)", "at_zero[first]"),
        ("list(map(min, nearest", "list(map(max, nearest"),
        ("- mine - potentials[v]", "- mine"),
    ),
    # tours.py
    *mutants(
        "tours.py",
        STRONG,
        ("kept = not tour.via or", "kept = True or"),
        ("first_ones & tour.contours == first_ones", "True"),
        ("(self.metric and within", "(within"),
        ("self.metric and within and kept", "self.metric and kept"),
        ("if tour.head == head]", "]"),
    ),
    *mutants(
        "tours.py",
        REACHED,
        ("tour.length > best and", "best == 0 and"),
    ),
    *mutants(
        "tours.py",
        "forgeries_are_refused",
        ("len(set(contours)) == len(contours)", "True"),
        ("len(nodes) <= 3", "len(nodes) <= 9"),
        ("proved >= length", "True"),
        ("require(value >= target", "require(True"),
        ("require(asked or not via", "require(True"),
        ("head < len(problem.homes)", "head <= len(problem.homes)"),
    ),
    *mutants(
        "tours.py",
        "proofs_with_via_points_pass_to_sets_with_the_same_leftmost",
        ("(keeps and first_ones", "(first_ones"),
        ("and not floating", ""),
        ("kept = not tour.via or", "kept = False and not tour.via or"),
        ("> self.problem.xs[first]", ">= self.problem.xs[first]"),
        ("via and differ", "via"),
        ("via and differ", "False"),
    ),
    # split.py
    *mutants(
        "split.py",
        "bounds_of_cells_are_the_least_values",
        ("abs(times[0] - times[1]) - works[2]", "abs(times[0] - times[1])"),
        ("min(rules.weight / problem.v_jump, Fraction(1))", "rules.weight / problem.v_jump"),
        ("+ (apart - kept)", "+ 2 * (apart - kept)"),
        ("+ (apart - kept)", ""),
        ("self.price * kept", "0"),
        ("min(apart, self.limit)", "apart"),
        ("min(apart, self.limit)", "max(apart, self.limit)"),
        ("sum(times) + works[2]) / 2", "sum(times) + works[2])"),
        ("max(*times,", "max("),
    ),
    *mutants(
        "split.py",
        "cells_are_all_partitions",
        ("for k in range(count + 1):", "for k in range(1, count):"),
        ("for k in range(count + 1):", "for k in range(count):"),
        ("jump > 0 and jump >= self.gap", "jump > 0"),
        ("jump >= self.gap", "jump > self.gap"),
        ("if self.gap == 0 else []", "if self.gap != 0 else []"),
        ("len(group) > 1", "len(group) > 2"),
        ("if not floating and not (left and right) and", "if False and"),
    ),
    *mutants(
        "split.py",
        STRONG,
        ("for k in range(count + 1):", "for k in range(1, count):"),
        ("for k in range(count + 1):", "for k in range(count):"),
        ("for k in range(count + 1):", "for k in range(0, count + 1, 2):"),
        ("jump >= self.gap", "jump > 2 * self.gap + 100"),
        ("sum(times) + works[2]) / 2", "sum(times) + works[2])"),
        ("bound >= (self.claim or 0)", "True"),
        ("self._check_ties(group[0], group[-1] + 1, tree)", "pass"),
        ("(left, [*right, contour])", "([*left, contour], right)"),
    ),
    *mutants(
        "split.py",
        REACHED,
        ("if not floating and not (left and right) and", "if False and"),
        ("max(*times,", "max("),
    ),
    *mutants(
        "split.py",
        "forgeries_are_refused",
        ("require(self.claim is not None", "require(True"),
        ("not may_rest(self.problem, self.rules)", "True"),
        ("child > index", "True"),
        ("contour is None or contour not in floating", "False"),
        ('entries(ties, "ties", len(groups)), strict=True', 'entries(ties, "ties"), strict=False'),
        ("require(all(reached)", "require(True"),
    ),
    # checker.py
    *mutants(
        "checker.py",
        "forgeries_are_refused",
        ('table["instance"] == problem.digest', "True"),
        ("proved.contours == (1 << len(problem.ids)) - 1", "True"),
        ("worth >= bound", "True"),
        ("bound is not None and worth", "worth"),
        ('table["version"] == 1', "True"),
        ("len(problem.homes) == 1", "True"),
    ),
    *mutants(
        "checker.py",
        "samples_are_verified",
        ("scale * problem.v_jump if unit", "scale if unit"),
        ("target = 1 if bound is None else", "target = 2**200 if bound is None else"),
        ("worth += sum(", "worth -= sum("),
    ),
    *mutants(
        "checker.py",
        "samples_prove_no_more",
        ("relaxation.factor * bound", "bound // 2"),
        ("multiplier_scale * relaxation", "relaxation"),
    ),
    Mutant("checker.py", "rules_of(rules, problem) == stated", "True", "other_rules_are_refused"),
    # plan.py
    *mutants(
        "plan.py",
        "plans_are_checked",
        ("apart >= rules.non_overlap", "apart <= rules.non_overlap"),
        ("xs[0] == min(xs)", "True"),
        ("imbalance <= rules.balance", "True"),
        ("cut == list(range(len(problem.ids)))", "True"),
        ("len(working) == len(tours) or", "True or"),
        ('integer(entry, "plan, entry") == 0', "True"),
    ),
    *mutants(
        "plan.py",
        "plans_are_worth_what_the_library_says",
        ("home, *tour, home]", "home, *tour]"),
        ("max(high / problem.v_jump + work, -low / problem.v_jump - work)", "high / problem.v_jump + work"),
        ("work = seconds[0] - seconds[1]", "work = seconds[0] + seconds[1]"),
        ("rules.weight * imbalance", "imbalance"),
    ),
    Mutant("plan.py", "problem.length_key(u, v)", "(u, v)", "equal_tours_balance_exactly"),
]
