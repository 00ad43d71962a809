"""Two heads, live: move a slider, and plan, proved bound, gap and ladder of formulations follow.

Start it with ``make live``. All work is done by plain functions, which can be imported; the cells only show it.
"""

import marimo

app = marimo.App(width="medium", app_title="cutgap: two heads, live")

with app.setup:
    from dataclasses import dataclass, replace

    import marimo as mo

    from cutgap.formulations import ladder, solve
    from cutgap.instances import Instance, Machine, Result, Rules, Status
    from cutgap.instances.generate import generate
    from cutgap.views.bound_plot import ladder_figure
    from cutgap.views.plots import PAGE_WIDTH, plan_figure
    from cutgap.views.svg import inline_svg, page_style

    TIME_LIMIT_S = 1.0
    # The other rungs take longer than a slider's user waits, or do not apply to holes.
    FAST_RUNGS = ("assignment", "mtz", "single-commodity", "two-matching", "one-tree", "held-karp")


@app.class_definition
@dataclass(frozen=True)
class Setting:
    """What the sliders say; ``balance_s`` and ``non_overlap_mm`` are ``None`` when called off."""

    holes: int = 18
    seed: int = 1
    v_jump: float = 150.0  # mm/s
    v_cut: float = 40.0  # mm/s
    non_overlap_mm: float | None = 0.0
    balance_s: float | None = None
    objective: str = "travel"

    def instance(self) -> Instance:
        """Return the part, on a machine with these speeds."""
        part = generate("random", holes=self.holes, seed=self.seed)
        return replace(part, machine=Machine(v_jump=self.v_jump, v_cut=self.v_cut))

    def rules(self) -> Rules:
        """Return what is asked of a plan."""
        return Rules(self.objective, non_overlap=self.non_overlap_mm, balance=self.balance_s)


@app.function
def solved(setting: Setting) -> Result:
    """Return the exact method's result after ``TIME_LIMIT_S`` at most: plan, value and proved bound."""
    return solve(setting.instance(), setting.rules(), time_limit=TIME_LIMIT_S, certify=True)


@app.function
def headline(result: Result) -> str:
    """Return value, bound and gap as a line of Markdown, or why there is no plan."""
    unit = result.rules.unit
    if result.status is Status.INFEASIBLE:
        return (
            f"**No plan is allowed**, and that is proved: {result.reason}. Loosen the gap or the balance limit."
        )
    if result.value is None or result.violations:
        known = (
            "" if result.lower_bound is None else f" None can be better than {result.lower_bound:.2f} {unit}."
        )
        return (
            f"**No plan was found** within {TIME_LIMIT_S:g} s, nor a proof that there is none.{known} "
            "Loosen the balance limit or take fewer holes."
        )
    value = f"**{result.rules.objective} {result.value:.2f} {unit}**"
    if result.lower_bound is None:
        return f"{value}, no bound within {TIME_LIMIT_S:g} s"
    # As in all tables: proved is what a checked certificate shows, the rest is a solver's word.
    word = "claimed" if result.certificate is None else "proved"
    bound = f"{word} bound {result.lower_bound:.2f} {unit}, gap {100 * result.gap:.2f} %"
    return f"{value}, {bound}: " + (
        "no plan is better." if result.status is Status.OPTIMAL else "a better plan may exist, within the gap."
    )


@app.function
def heads_table(instance: Instance, result: Result) -> str:
    """Return time and travel of each head as a table in Markdown."""
    rows = ["| head | holes | travel [mm] | time [s] |", "|---|---|---|---|"]
    figures = result.evaluation
    for head, tour, travel, time in zip(
        instance.heads, result.plan.tours, figures.travel_mm, figures.time_s, strict=True
    ):
        rows.append(f"| {head.id} | {len(tour)} | {travel:.1f} | {time:.2f} |")
    gap = "" if figures.partition_gap_mm is None else f", partition gap {figures.partition_gap_mm:.1f} mm"
    return "\n".join(rows) + f"\n\nImbalance {figures.imbalance_s:.2f} s{gap}."


@app.function
def balance_price(limited: Result, free: Result) -> str:
    """Return in words what the balance limit costs, claiming no more than the two results prove."""
    if limited.rules.balance is None:
        return "No balance limit is set, so balance costs nothing."
    unit = limited.rules.unit
    if limited.status is Status.INFEASIBLE or free.value is None:
        return "What the balance limit costs cannot be said: one of the two problems has no plan."
    least = max(0.0, (limited.lower_bound or 0.0) - free.value)
    if limited.value is None or limited.violations:
        return f"The balance limit costs at least {least:.2f} {unit}."
    most = max(0.0, limited.value - (free.lower_bound or 0.0))
    if most <= 1e-6 * free.value:
        return "The balance limit costs nothing here: a best plan keeps it anyway."
    if most - least <= 1e-6 * free.value:
        return f"The balance limit costs **{most:.2f} {unit}** ({100 * most / free.value:.2f} %)."
    return f"The balance limit costs between {least:.2f} and {most:.2f} {unit}; more is not known in time."


@app.function
def picture(svg: str) -> mo.Html:
    """Return a picture as wide as the page, in colours that follow light and dark."""
    return mo.Html(f'<figure class="cutgap">{svg}</figure>')


@app.function
def plan_picture(instance: Instance, result: Result) -> mo.Html:
    """Draw the plan, or the bare part when there is none."""
    plan = None if result.violations else result.plan
    words = "no plan" if plan is None else f"plan of {len(instance.contours)} holes for two heads"
    with page_style("plan"):
        figure = plan_figure(instance, plan, width=PAGE_WIDTH)
        return picture(inline_svg(figure, f"{instance.name}: {words}"))


@app.function
def climbed(instance: Instance, result: Result) -> tuple[list, list[str]]:
    """Return the rungs with a bound, lowest first and the exact method last, and why others have none."""
    found = list(ladder(instance, result.rules, names=FAST_RUNGS, time_limit=TIME_LIMIT_S))
    rungs = sorted((rung for rung in found if rung.bound is not None), key=lambda rung: rung.bound)
    return rungs, [f"{rung.formulation}: {rung.note}" for rung in found if rung.bound is None]


@app.function
def ladder_picture(instance: Instance, result: Result, rungs: list) -> mo.Html:
    """Draw what each formulation proves against the value of the plan."""
    value = None if result.violations else result.value
    with page_style("ladder"):
        figure = ladder_figure(instance.name, rungs, value, result.rules.unit, narrow=True)
        words = ", ".join(f"{rung.formulation} {rung.bound:.2f}" for rung in rungs)
        return picture(inline_svg(figure, f"bounds in {result.rules.unit}: {words}"))


@app.function
def ladder_table(result: Result, rungs: list) -> str:
    """Return the same bounds as a table in Markdown, strongest first, as in the picture."""
    value = None if result.violations else result.value
    rows = [
        f"| formulation | bound [{result.rules.unit}] | gap [%] | variables | time [s] |",
        "|---|---|---|---|---|",
    ]
    for rung in reversed(rungs):
        gap = rung.gap(value)
        share = "" if gap is None else f"{100 * gap:.2f}"
        size = "" if rung.variables is None else rung.variables
        rows.append(f"| {rung.formulation} | {rung.bound:.2f} | {share} | {size} | {rung.seconds:.2f} |")
    return "\n".join(rows)


@app.cell
def _():
    mo.md("""
    # Two heads, live

    Two heads share the holes of a part. The **plan** below is the best one found. No allowed plan is better
    than the **bound**; the **gap** between the two is what is not known yet: at 0 % the plan is optimal.
    A limit on the **imbalance** of the heads' times costs travel: a head that would be done first may even take
    a longer way to keep it. The **ladder** shows how much of the value simpler models prove.
    """)
    return


@app.cell
def _():
    def slider(label, *span, value):
        return mo.ui.slider(*span, value=value, label=label, show_value=True, debounce=True, full_width=True)

    holes = slider("holes", 2, 30, 1, value=18)
    seed = slider("seed of the part", 0, 50, 1, value=1)
    v_jump = slider("speed of rapids v_jump [mm/s]", 50, 500, 10, value=150)
    v_cut = slider("speed of cutting v_cut [mm/s]", 10, 100, 5, value=40)
    non_overlap = slider("least gap between the heads' ranges [mm]", 0, 1000, 10, value=0)
    balance = slider("largest imbalance [s]", 0, 10, 0.25, value=2)
    limited = mo.ui.switch(value=True, label="limit the imbalance")
    overlap = mo.ui.switch(value=False, label="let the ranges overlap")
    objective = mo.ui.dropdown(["travel", "makespan"], value="travel", label="make least")
    mo.vstack(
        [
            mo.hstack([objective, limited, overlap], justify="start", gap=2, wrap=True),
            holes,
            seed,
            v_jump,
            v_cut,
            non_overlap,
            balance,
        ]
    )
    return balance, holes, limited, non_overlap, objective, overlap, seed, v_cut, v_jump


@app.cell
def _():
    # Colours of the pictures by light and dark, as in the other pages.
    mo.Html("""<style>
    .cutgap { --head-0: #0072b2; --head-1: #d55e00; --head-2: #009e73; --head-3: #b0558a; --grey: #7a828c;
      --ground: var(--background); margin: 0; }
    .dark .cutgap { --head-0: #56b4e9; --head-1: #f28e3c; --head-2: #2fc79a; --head-3: #e39cc5;
      --grey: #8d96a1; }
    .cutgap svg { width: 100%; height: auto; max-width: 40rem; display: block; }
    </style>""")
    return


@app.cell
def _():
    # Kernels are compiled, or read from the cache, before the clock of a time limit runs.
    for _gap in (0.0, None):
        solve(Setting(holes=6).instance(), Rules("travel", non_overlap=_gap, balance=2.0))
    warm = True
    return (warm,)


@app.cell
def _(balance, holes, limited, non_overlap, objective, overlap, seed, v_cut, v_jump, warm):
    setting = Setting(
        holes=holes.value,
        seed=seed.value,
        v_jump=float(v_jump.value),
        v_cut=float(v_cut.value),
        non_overlap_mm=None if overlap.value else float(non_overlap.value),
        balance_s=float(balance.value) if limited.value and warm else None,
        objective=objective.value,
    )
    instance, result = setting.instance(), solved(setting)
    return instance, result, setting


@app.cell
def _(instance, result):
    _shown = [mo.callout(mo.md(headline(result)), kind="info" if result.status is Status.OPTIMAL else "warn")]
    _shown.append(plan_picture(instance, result))
    if result.plan is not None and not result.violations:
        _shown.append(mo.md(heads_table(instance, result)))
    mo.vstack(_shown)
    return


@app.cell
def _(result, setting):
    free = result if setting.balance_s is None else solved(replace(setting, balance_s=None))
    mo.md(balance_price(result, free))
    return


@app.cell
def _(instance, result):
    rungs, notes = climbed(instance, result)
    _without = mo.md("Without a bound:\n" + "".join(f"\n- {note}" for note in notes)) if notes else None
    _shown = [ladder_picture(instance, result, rungs), mo.md(ladder_table(result, rungs)), _without]
    mo.vstack([each for each in _shown if each is not None])
    return


if __name__ == "__main__":
    app.run()
