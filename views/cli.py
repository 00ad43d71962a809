"""The command ``cutgap``. Exit codes: 0 good, 1 a check or proof failed or there is no plan, 2 bad input."""

import os
import sys
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from typing import TextIO

from cyclopts import App, CycloptsError, Parameter

from cutgap.instances.formats.options import FormatNote

GOOD, BAD_INPUT, INTERRUPTED = 0, 2, 130

app = App(
    name="cutgap",
    help="Optimality gaps of laser and flame cutting plans.",
    version=lambda: version("cutgap"),
    default_parameter=Parameter(negative=""),
    result_action="return_value",
)
# Named by text, so that a command loads only what it needs: the solvers take a second.
COMMANDS = {
    "gaps": ("cutgap.views.gaps:app", "Compare methods with proved optima or bounds over a suite."),
    "solve": ("cutgap.views.solving:solve", "Plan one instance and say how far the plan is from the optimum."),
    "check": ("cutgap.views.checking:check", "Check a plan against every rule."),
    "pareto": ("cutgap.views.fronts:pareto", "Show how much travel each limit on imbalance costs."),
    "verify": ("cutgap.views.verifying:verify", "Prove a bound again in exact arithmetic, without any solver."),
    "ladder": ("cutgap.views.ladder:ladder", "Show the bounds of all formulations on one instance."),
    "generate": ("cutgap.views.files:generate", "Draw a random instance of a reference experiment."),
    "convert": ("cutgap.views.files:convert", "Write an instance in another format."),
    "play": ("cutgap.views.playing:play", "Write a page to step through the run of an exact method."),
    "plot": ("cutgap.views.drawing:plot", "Draw an instance, or a plan for it, from above."),
}
for order, (name, (function, summary)) in enumerate(COMMANDS.items()):
    app.command(function, name=name, help=summary, sort_key=order)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run a command line (``sys.argv`` by default) and return the exit code."""
    try:
        with warnings.catch_warnings():
            _print_notes()
            code = app(tokens, exit_on_error=False, print_error=False)
        sys.stdout.flush()
        return GOOD if code is None else int(code)
    except BrokenPipeError:
        # Whoever read the output has had enough; Python must not complain when it flushes at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return GOOD
    except (CycloptsError, ValueError, OSError) as error:
        print(f"cutgap: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("cutgap: interrupted", file=sys.stderr)
        return INTERRUPTED


def _print_notes() -> None:
    """Have notes of readers printed like the messages of commands; other warnings stay as they are."""
    others = warnings.showwarning

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, FormatNote):
            print(f"cutgap: note: {message}", file=sys.stderr)
        else:
            others(message, category, filename, lineno, file, line)

    warnings.simplefilter("always", FormatNote)
    warnings.showwarning = show


if __name__ == "__main__":
    sys.exit(main())
