"""The report's headline figures against the records that they summarise."""

import re
from dataclasses import replace
from statistics import fmean

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.benchmark.executors import SerialExecutor
from cutgap.benchmark.runner import run_tasks
from cutgap.benchmark.table import gap_table
from cutgap.benchmark.tasks import instance_hash, suite_tasks
from cutgap.instances import Rules
from cutgap.instances.suites import load_suite
from cutgap.views.report import Run, report_html
from cutgap.views.report_plans import DRAWN_PARTS

METHODS = ("split", "local-search", "k-means")


def report(instances, methods=METHODS):
    """Return the page of a suite and its records."""
    tasks = suite_tasks([(each, Rules()) for each in instances], methods, seeds=1)
    records = list(run_tasks(tasks, SerialExecutor()))
    run = Run("suite", (Rules(),), methods, 1, None, len(tasks))
    by_hash = {instance_hash(instance): instance for instance in instances}
    return report_html(run, records, gap_table(records), by_hash), records


def cards(page):
    return re.findall(r'<div class="card"><b>(.*?)</b><span>(.*?)</span></div>', page)


@pytest.fixture(scope="module")
def instances():
    rng = np.random.default_rng(31)
    return tuple(random_instance(rng, 7, layout="uniform") for _ in range(2))


def test_the_best_heuristic_is_named_even_when_it_has_no_gap(instances):
    page, records = report(instances)
    optima = {r.instance_hash: r.result.value for r in records if r.result.method == "split"}
    gaps = {
        method: fmean(
            (r.result.value - optima[r.instance_hash]) / r.result.value
            for r in records
            if r.result.method == method and not r.result.violations
        )
        for method in ("local-search", "k-means")
    }
    # The case is the one that is meant: one heuristic without a gap, the other with one.
    assert gaps["local-search"] < 1e-7 < gaps["k-means"]
    found = {text: figure for figure, text in cards(page)}
    assert found["mean gap of local-search, the least of the heuristics"] == "0.000 %"
    assert found["mean gap of k-means, the largest"] == f"{100 * gaps['k-means']:.3f} %"
    assert found["parts with a proven optimum"] == "2 of 2"


def test_without_a_bound_there_is_no_gap_to_show(instances):
    page, _ = report(instances, ("k-means",))
    assert "No gap is known" in page
    assert not any("mean gap" in text for _, text in cards(page))


def test_a_long_suite_draws_its_first_parts_and_says_so():
    rng = np.random.default_rng(32)
    many = tuple(random_instance(rng, 2, layout="uniform") for _ in range(DRAWN_PARTS + 1))
    page, _ = report(many, ("split",))
    assert f"The first {DRAWN_PARTS} of {DRAWN_PARTS + 1} parts are drawn" in page
    assert page.count('aria-label="plan of') == DRAWN_PARTS


def test_a_bound_on_the_peak_leads_to_its_certificate():
    plate, rules = load_suite("small-plates")[0], Rules("peak")
    (task,) = suite_tasks([(plate, rules)], ("heat",), seeds=1)
    (record,) = run_tasks([task], SerialExecutor())
    record = replace(record, certificate="proof.json")
    run = Run("suite", (rules,), ("heat",), 1, None, 1)
    page = report_html(run, [record], gap_table([record]), {instance_hash(plate): plate})
    cells = re.findall(r"<td>(.*?)</td>", page)
    assert f'<a href="certificates/proof.json">= {record.result.lower_bound:.2f}</a>' in cells
    assert "1 part; asked for" in page
