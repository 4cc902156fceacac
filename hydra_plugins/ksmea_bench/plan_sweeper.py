"""The one place where Hydra meets the plan.

The command line becomes a plan, its batches go through the launcher.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from hydra.core.config_store import ConfigStore
from hydra.core.plugins import Plugins
from hydra.core.utils import JobStatus
from hydra.plugins.sweeper import Sweeper
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, flag_override

from bench.command_line.output_level import is_quiet
from bench.jobs.claims import clear
from bench.jobs.offers import dealt
from bench.jobs.superseded import earlier_notes
from bench.plan.experiment import Experiment
from bench.plan.size import size_line
from bench.storage.files import exclusive
from ksmea.errors import visible

# A plain node: Hydra scans this file outside sys.modules, where a dataclass cannot resolve its annotations.
TARGET = {"_target_": "hydra_plugins.ksmea_bench.plan_sweeper.PlanSweeper"}
ConfigStore.instance().store(group="hydra/sweeper", name="plan", node=TARGET, provider="ksmea_bench")


class PlanSweeper(Sweeper):
    """Plans the experiment, then launches one job per batch that still has work."""

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        self.config = config
        self.hydra_context = hydra_context
        self.launcher = Plugins.instance().instantiate_launcher(
            hydra_context=hydra_context, task_function=task_function, config=config
        )

    def sweep(self, arguments: list[str]) -> Any:
        experiments = Experiment.compose_all(self.hydra_context.config_loader, self.config, arguments)
        codes = [self._run(experiment) for experiment in experiments]
        if len(experiments) > 1:
            from bench.reports.collect_all import collect_all  # loads all of matplotlib

            collect_all(Path(self.config.output), [experiment.output for experiment in experiments])
        sys.exit(max(codes))

    def _run(self, experiment: Experiment) -> int:
        """Plan, launch and collect one experiment; its exit code."""
        from bench.reports.collect import collect

        if not is_quiet() and (line := size_line(experiment.plan)):
            print(f"{visible(line)} in {visible(str(experiment.output))}", file=sys.stderr)
        with exclusive(experiment.output / ".lock"):
            notes = earlier_notes(experiment.plan, experiment.output)
            jobs = dealt(experiment)
            try:
                if jobs:
                    with flag_override(self.config, ["readonly", "struct"], False):
                        self.config.hydra.sweep.dir = str(experiment.output)  # or the launcher makes another folder
                    for job in self.launcher.launch(jobs, initial_job_idx=0):
                        if job.status == JobStatus.FAILED:
                            raise job._return_value  # as `return_value` does, without its remark on stderr
                        if job.status == JobStatus.UNKNOWN:  # submitted, and not waited for
                            return 0
            except Exception:
                collect(experiment.output)  # what there is; then the reason why it is not all
                raise
            clear(experiment.output)
            code = collect(experiment.output, redraw=False)
            if not is_quiet():
                for note in notes:
                    print(visible(note))
            return max(code, 1) if experiment.has_left_out else code
