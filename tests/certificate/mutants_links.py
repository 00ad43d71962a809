"""Small errors in the checker's rules for plans with links."""

from certificate.mutants import Mutant, mutants

REACHED = "proofs_of_links_reach_the_optimum"
MOST = "links_prove_no_more_than_the_optimum"
COEFFICIENTS = "rows_of_links_have_their_coefficients"
COUNTED = "joints_between_places_are_counted"
PAID = "negative_counts_are_paid"
FIXED = "fixed_variables_count_at_their_value"
FORGED = "forged_proofs_of_links_are_refused"
CLEAR = "links_are_blocked_or_clear"
HOLE = "what_lies_in_a_hole_is_no_material"
PLANS = "plans_with_links_are_checked"

LINKS: list[Mutant] = [
    *mutants(
        "checker.py",
        FORGED,
        ("require(rules.links == linked", "require(True"),
    ),
    *mutants(
        "link_costs.py",
        REACHED,
        ("floor(self.scale * self.pierce * ends / 2)", "floor(self.scale * self.pierce * ends)"),
        ("2 * min(costs)", "min(costs)"),
        ("problem.v_jump / problem.v_cut if timed", "problem.v_cut / problem.v_jump if timed"),
    ),
    *mutants(
        "link_plan.py",
        PLANS,
        ("material is None or material.is_clear(p, q)", "True"),
        ("len(visits) <= rules.pierces", "True"),
        ("sorted(visited) == sorted(set(group))", "set(visited) == set(group)"),
        ("sorted(visited) == sorted(set(group))", "True"),
        ("len(loose) == 2 and start in loose", "len(loose) == 2"),
        ("len(set(pairs)) == len(pairs)", "True"),
        ("problem.t_aux * len(visits)", "problem.t_aux"),
        ("(linked + perimeter) / problem.v_cut", "linked / problem.v_jump + perimeter / problem.v_cut"),
        ("passes * _most", "_most"),
        ("[::2]", ""),
    ),
    *mutants(
        "link_prices.py",
        COUNTED,
        ("self.excess.get((i, j), 0) - 2 * price", "self.excess.get((i, j), 0) - price"),
        ("self.excess.get(pair, 0) - 2 * price", "self.excess.get(pair, 0)"),
        ("self.triples.get(triple, 0) - price", "self.triples.get(triple, 0)"),
        ("self.triples.get(triple, 0) + price", "self.triples.get(triple, 0)"),
        ("self.partitions.append((price, label))", "pass"),
        ("(price * (count - 2), label)", "(price * (count - 1), label)"),
        ("len({label[place] for place in triple}) > 1", "len({label[place] for place in triple}) > 2"),
    ),
    *mutants(
        "link_prices.py",
        REACHED,
        ("self.odd.get(edge, 0) + 2 * price", "self.odd.get(edge, 0)"),
        ("self.node[node] += price", "self.node[node] -= price"),
        ("self.double[contour][home] += 2 * price", "self.double[contour][home] += 3 * price"),
    ),
    *mutants(
        "link_prices.py",
        COEFFICIENTS,
        ("self.value += price * count * (count - 1)", "self.value += price * count * count"),
        ("self.value += price * (1 - len(odd))", "self.value += price * (2 - len(odd))"),
        ("self.value -= 2 * price * len(members)", "self.value -= price * len(members)"),
        ("self.value += price * (1 - most)", "self.value += price"),
        ("label, price * (count - 1), price * count)", "label, price * count, price * count)"),
        ("label, price * (count - 1), price * count)", "label, price * (count - 1), price * (count + 1))"),
        ("self.end[contour] -= price", "self.end[contour] += price"),
        ("self.rapid -= price", "self.rapid += price"),
        ("self.double[contour][-1] -= 2 * price", "pass"),
        ("self.tree.get(edge, 0) + 2 * price", "self.tree.get(edge, 0) + price"),
        ("self.value += price * (count - 1)", "self.value += price * count"),
        ("self.single[i][j] -= price", "pass"),
        ("self.toward[node, j] = self.toward.get((node, j), 0) + 2 * price", "pass"),
        ("((j, k), (i, k))", "((i, k), (j, k))"),
        ("self.single[one][other] += price", "self.single[one][other] -= price"),
    ),
    *mutants(
        "links.py",
        FIXED,
        ("value += at * self._reduced(edge, prices)", "value += abs(self._reduced(edge, prices))"),
        ("value += at * self._reduced(edge, prices)", "pass"),
        ("0 if edge in fixed else min", "min"),
    ),
    *mutants(
        "links.py",
        FORGED,
        ("len(set(pairs)) == len(pairs)", "True"),
        ("inside.issubset(self.costs.members[place])", "True"),
        ("i < j < k <= self.costs.home", "i <= j <= k <= self.costs.home"),
        ("require(shown,", "require(True,"),
        ("len(set(members)) == len(members)", "len(members) > 0"),
        ("len(odd) % 2 == 1", "len(odd) >= 1"),
        ("(p in inside) != (q in inside) for", "(p in inside) or (q in inside) or True for"),
        ("leader[i] != leader[j]", "True"),
        ('require(price >= 0 or kind == "home"', 'require(True or kind == "home"'),
        ("require(value >= target", "require(True"),
        ("0 <= index < len(self.rows)", "index < len(self.rows)"),
        ("p < q < costs.home_node and share <= SHARES", "p < q and share <= SHARES"),
        ("p < q < costs.home_node and share <= SHARES", "p < q < costs.home_node"),
        ("index < child < len(tree)", "0 <= child < len(tree)"),
        ('require(table["at"] == 0', "require(True"),
        ("costs.place_of[p] != costs.place_of[q]", "True"),
    ),
    *mutants(
        "links.py",
        COUNTED,
        ("min(0, reduced) * len(self.costs.members[i])", "min(0, reduced)"),
    ),
    *mutants(
        "links.py",
        MOST,
        ("value += self._pay((DOUBLE, i, costs.home), prices, fixed)", "pass"),
        ("0 if edge in fixed else min(0, self._reduced(edge, prices))", "0"),
    ),
    *mutants(
        "links.py",
        PAID,
        ("value += sum(min(0, reduced) for reduced in prices.triples.values())", "pass"),
        ("value += sum(self._excess(", "sum(self._excess("),
    ),
    *mutants(
        "links.py",
        REACHED,
        ("problem.v_jump * perimeter / problem.v_cut", "perimeter / problem.v_cut"),
    ),
    *mutants(
        "links.py",
        COEFFICIENTS,
        ("sum(2 * price for inside", "sum(price for inside"),
        ("prices.rapid if j < costs.home else 0", "prices.rapid"),
        ("prices.toward.get((p, j), 0) + prices.toward.get((q, i), 0)", "prices.toward.get((p, j), 0)"),
    ),
    *mutants(
        "material.py",
        CLEAR,
        ("return odd", "return not odd"),
        ("% 2 == 0", "% 2 == 1"),
        ("0 <= share <= 1 and 0 <= along <= 1", "0 <= share <= 1 and along <= 0"),
    ),
    *mutants(
        "material.py",
        HOLE,
        ("odd ^= inside(point, edges)", "odd |= inside(point, edges)"),
        ("<= margin * margin", "< 0"),
        ("margin = 2 * self.depth", "margin = self.depth / 2"),
        ("Fraction(1, 10**7)", "Fraction(1, 10**6)"),
        ("Fraction(1, 10**7)", "Fraction(1, 10**9)"),
    ),
    *mutants(
        "rules.py",
        FORGED,
        ("require(alone or not rules.links", "require(True"),
    ),
]
