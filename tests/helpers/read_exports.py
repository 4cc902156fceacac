"""What the programs of other benchmarks read of exports: `python read_exports.py ioh|coco FOLDER` prints it as JSON."""

import json
import sys
from pathlib import Path


def read_ioh(folder):
    """By algorithm, function, dimension and run of its table: instance, evaluations of the run, and rows of cost, value, error."""
    import iohinspector

    manager = iohinspector.DataManager()
    manager.add_folder(folder)
    names = ["algorithm_name", "function_name", "dimension", "instance", "run_id", "evals", "best_y"]
    rows = manager.load(monotonic=False, include_meta_data=True)
    return rows.select(*names, "evaluations", "raw_y", "error").rows()


def read_coco(folder):
    """By archive: instances, evaluations of each run, and rows of a value and the evaluations that each run took to it."""
    import cocopp

    found = {}
    for archive in sorted(Path(folder).glob("*.tar.gz")):
        for data in cocopp.load(str(archive)):
            place = f"{archive.name} f{data.funcId} {data.dim}"
            found[place] = [data.instancenumbers, data.maxevals.tolist(), data.evals.tolist()]
    return found


if __name__ == "__main__":
    print(json.dumps({"ioh": read_ioh, "coco": read_coco}[sys.argv[1]](sys.argv[2])))
