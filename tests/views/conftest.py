import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.instances.formats import write_instance


@pytest.fixture
def part(tmp_path):
    """Path of an instance with two heads and six holes."""
    path = tmp_path / "part.json"
    write_instance(random_instance(np.random.default_rng(5), 6, layout="uniform"), path)
    return path


@pytest.fixture
def parts(tmp_path):
    """Folder of three instances."""
    folder = tmp_path / "parts"
    folder.mkdir()
    rng = np.random.default_rng(6)
    for holes in (5, 6, 7):
        write_instance(random_instance(rng, holes, layout="uniform"), folder / f"part-{holes}.json")
    return folder
