"""Content of exports as other programs read it: `python read_exports.py ioh|coco FOLDER`.

It is printed as JSON.
"""

import json
import sys
from pathlib import Path


def read_ioh(folder):
    """Instances and rows of exports, by algorithm, function, dimension and run.

    They are the instance, evaluations of the run, and rows of cost, value, error.
    """
    import iohinspector

    manager = iohinspector.DataManager()
    manager.add_folder(folder)
    names = ["algorithm_name", "function_name", "dimension", "instance", "run_id", "evals", "best_y"]
    rows = manager.load(monotonic=False, include_meta_data=True)
    return rows.select(*names, "evaluations", "raw_y", "error").rows()


def read_coco(folder):
    """Instances, evaluations and rows of value and evaluations, by archive.

    Evaluations are of each run; rows state the evaluations that each run took to a value.
    """
    import cocopp

    found = {}
    for archive in sorted(Path(folder).glob("*.tar.gz")):
        for data in cocopp.load(str(archive)):
            place = f"{archive.name} f{data.funcId} {data.dim}"
            found[place] = [data.instancenumbers, data.maxevals.tolist(), data.evals.tolist()]
    return found


if __name__ == "__main__":
    print(json.dumps({"ioh": read_ioh, "coco": read_coco}[sys.argv[1]](sys.argv[2])))
