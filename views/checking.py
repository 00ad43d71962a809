"""The command ``check``."""

import json as json_library

from cutgap.benchmark.wording import describe
from cutgap.instances import check as find_violations
from cutgap.instances import evaluate
from cutgap.instances.formats import read_instance, read_plan
from cutgap.views.figures import evaluation_fields, print_evaluation
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    File,
    Json,
    MachineArguments,
    PlanFile,
    RuleOptions,
)


def check(
    file: File,
    plan: PlanFile,
    /,
    *,
    rules: RuleOptions = DEFAULT_RULES,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Check a plan: print its figures and every rule that it breaks; exit code 1 if it breaks any."""
    instance = read_instance(file, machine.options())
    asked = rules.rules()
    tours = read_plan(plan, instance)
    violations = find_violations(instance, asked, tours)
    evaluation = evaluate(instance, tours)
    if json:
        found = [
            {"constraint": each.constraint, "place": each.place, "amount": each.amount, "unit": each.unit}
            for each in violations
        ]
        fields = {
            "allowed": not violations,
            "violations": found,
            "objective": asked.objective,
            "value": evaluation.objective(asked),
            "evaluation": evaluation_fields(evaluation),
        }
        print(json_library.dumps(fields, indent=2, allow_nan=False))
        return 1 if violations else 0
    verdict, words = "breaks rules" if violations else "is allowed", describe(asked, len(instance.heads))
    print(f"{instance.name}: the plan {verdict} ({words})")
    for violation in violations:
        print(f"  broken         {violation}")
    print_evaluation(instance, tours, evaluation)
    return 1 if violations else 0
