"""The code in ``docs/certificates.md`` runs."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "certificates.md"


def test_code_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), {})
    proved, refused = capsys.readouterr().out.splitlines()
    assert proved.startswith("optimal within")
    assert "below the claimed" in refused
