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
        "links.py",
        COEFFICIENTS,
        ("prices.value += price * count * (count - 1)", "prices.value += price * count * count"),
        ("prices.value += price * (1 - len(odd))", "prices.value += price * (2 - len(odd))"),
        ("prices.value -= 2 * price * len(members)", "prices.value -= price * len(members)"),
        ("prices.value += price * (1 - (self.rules.pierces or 0))", "prices.value += price"),
        ("label, price * (count - 1), price * count)", "label, price * count, price * count)"),
        ("label, price * (count - 1), price * count)", "label, price * (count - 1), price * (count + 1))"),
    ),
    *mutants(
        "links.py",
        COEFFICIENTS,
        ("prices.end[contour] -= price", "prices.end[contour] += price"),
        ("prices.rapid -= price", "prices.rapid += price"),
        ("prices.double[contour][self.costs.home] -= 2 * price", "pass"),
        ("prices.tree.get(edge, 0) + 2 * price", "prices.tree.get(edge, 0) + price"),
        ("sum(2 * price for inside", "sum(price for inside"),
        ("prices.rapid if j < costs.home else 0", "prices.rapid"),
    ),
    *mutants(
        "links.py",
        COUNTED,
        ("prices.excess.get((i, j), 0) - 2 * price", "prices.excess.get((i, j), 0) - price"),
        ("prices.excess.get(pair, 0) - 2 * price", "prices.excess.get(pair, 0)"),
        ("prices.triples.get(triple, 0) - price", "prices.triples.get(triple, 0)"),
        ("prices.triples.get(triple, 0) + price", "prices.triples.get(triple, 0)"),
        ("prices.partitions.append((price, label))", "pass"),
        ("(price * (count - 2), label)", "(price * (count - 1), label)"),
        ("len({label[place] for place in triple}) > 1", "len({label[place] for place in triple}) > 2"),
        ("min(0, reduced) * len(self.costs.members[i])", "min(0, reduced)"),
    ),
    *mutants(
        "links.py",
        PAID,
        ("value += sum(min(0, reduced) for reduced in prices.triples.values())", "pass"),
        ("value += sum(self._excess(", "sum(self._excess("),
    ),
    *mutants(
        "links.py",
        COEFFICIENTS,
        ("prices.value += price * (count - 1)", "prices.value += price * count"),
        ("prices.single[i][j] -= price", "pass"),
        ("prices.toward[node, j] = prices.toward.get((node, j), 0) + 2 * price", "pass"),
        ("((j, k), (i, k))", "((i, k), (j, k))"),
        ("prices.toward.get((p, j), 0) + prices.toward.get((q, i), 0)", "prices.toward.get((p, j), 0)"),
        ("prices.single[one][other] += price", "prices.single[one][other] -= price"),
    ),
    *mutants(
        "links.py",
        FORGED,
        ("len(set(pairs)) == len(pairs)", "True"),
        ("inside.issubset(self.costs.members[place])", "True"),
        ("i < j < k <= self.costs.home", "i <= j <= k <= self.costs.home"),
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
        REACHED,
        ("prices.odd.get(edge, 0) + 2 * price", "prices.odd.get(edge, 0)"),
        ("prices.node[node] += price", "prices.node[node] -= price"),
        ("prices.double[contour][home] += 2 * price", "prices.double[contour][home] += 3 * price"),
        ("floor(self.scale * self.pierce * ends / 2)", "floor(self.scale * self.pierce * ends)"),
        ("2 * min(costs)", "min(costs)"),
        ("problem.v_jump / problem.v_cut if timed", "problem.v_cut / problem.v_jump if timed"),
        ("problem.v_jump * perimeter / problem.v_cut", "perimeter / problem.v_cut"),
    ),
    *mutants(
        "links.py",
        MOST,
        ("value += self._pay((DOUBLE, i, costs.home), prices, fixed)", "pass"),
        ("0 if edge in fixed else min(0, self._reduced(edge, prices))", "0"),
    ),
    *mutants(
        "links.py",
        FORGED,
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
        "material.py",
        CLEAR,
        ("return odd", "return not odd"),
        ("% 2 == 0", "% 2 == 1"),
        ("0 <= share <= 1 and 0 <= along <= 1", "0 <= share <= 1 and along <= 0"),
    ),
    *mutants(
        "material.py",
        HOLE,
        ("odd ^= _inside(point, edges)", "odd |= _inside(point, edges)"),
        ("<= margin * margin", "< 0"),
        ("margin = 2 * self.depth", "margin = self.depth / 2"),
        ("Fraction(1, 10**7)", "Fraction(1, 10**6)"),
        ("Fraction(1, 10**7)", "Fraction(1, 10**9)"),
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
        "checker.py",
        FORGED,
        ("require(rules.links == linked", "require(True"),
    ),
    *mutants("rules.py", FORGED, ("require(alone or not rules.links", "require(True")),
]
