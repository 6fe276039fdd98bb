# Served metrics as Prometheus' Python client reads them; the manual names each of them, the dashboard no other:
# read_metrics.py DASHBOARD MANUAL METRICS…
# promtool checks them as well where $DWELL_PROMTOOL names it or the system has it: its names, units and texts by convention.
import json
import os
import re
import shutil
import subprocess
import sys

from prometheus_client.parser import text_string_to_metric_families

promtool = os.environ.get("DWELL_PROMTOOL") or shutil.which("promtool")
served = set()
labels = {}  # by series name: labels that it is served with
for path in sys.argv[3:]:
    families = list(text_string_to_metric_families(open(path, encoding="utf-8").read()))
    if promtool:
        check = subprocess.run([promtool, "check", "metrics"], stdin=open(path), capture_output=True, text=True)
        assert check.returncode == 0, (path, check.stdout, check.stderr)
    names = [family.name for family in families]
    assert len(names) == len(set(names)), ("a family comes twice", names)
    for family in families:
        assert family.name.startswith("dwell_"), family.name
        assert family.documentation and family.type in ("gauge", "counter"), family
        series = [(sample.name, tuple(sorted(sample.labels.items()))) for sample in family.samples]
        assert series and len(series) == len(set(series)), ("no sample, or one twice", family)
        for sample in family.samples:
            assert sample.name.endswith("_total") == (family.type == "counter"), sample
            served.add(sample.name)
            labels.setdefault(sample.name, set()).update(sample.labels)
    rigs = [sample.labels["rig"] for family in families if family.name == "dwell_rig_info" for sample in family.samples]
    assert rigs == ['bench "2\\ \ufffd\n'], rigs

dashboard = json.load(open(sys.argv[1], encoding="utf-8"))
panels = dashboard["panels"]
ids = [panel["id"] for panel in panels]
assert len(ids) == len(set(ids)), "panels with the same id"
texts = [target["expr"] for panel in panels for target in panel.get("targets", [])]
texts += [variable["query"] for variable in dashboard["templating"]["list"] if variable["type"] == "query"]
asked = {name for text in texts for name in re.findall(r"\bdwell_[a-z0-9_]+", text)}
assert len(asked) > 20, asked
assert asked <= served, ("the dashboard asks for what is not served", asked - served)
wanted = {"dwell_limit_verdict", "dwell_channel_calibration_due_timestamp_seconds"}
assert wanted <= asked, ("an operator looks for these", wanted - asked)
for panel in panels:
    for target in panel.get("targets", []):
        known = set().union(*(labels[name] for name in re.findall(r"\bdwell_[a-z0-9_]+", target["expr"])))
        used = set(re.findall(r"{{(\w+)}}", target.get("legendFormat", "")))
        assert used <= known | {"instance"}, (panel["title"], "labels that are not served", used - known)
boxes = [(panel["title"], panel["gridPos"]) for panel in panels]
for i, (title, a) in enumerate(boxes):
    for other, b in boxes[i + 1:]:
        apart = any(a[at] + a[size] <= b[at] or b[at] + b[size] <= a[at] for at, size in (("x", "w"), ("y", "h")))
        assert apart, ("panels overlap", title, other)

named = set(re.findall(r"\bdwell_[a-z0-9_]+", open(sys.argv[2], encoding="utf-8").read()))
assert named == served, ("named but not served, served but not named", named - served, served - named)
