"""Every line of the operational log has an example in the section LOG of dwelld.8, and every example a line in the code.

A call's words are its string literals; an example of the same level must hold them. Where a call hands over words that
stand elsewhere, INDIRECT says where. Usage: log_lines.py SOURCE_FOLDER
"""
import pathlib
import re
import sys

# FILE OF THE CALL: [(what the call says, LEVEL, file with the words, the words)]
INDIRECT = {
    "daemon/alarms/alarms.cpp": [
        ("warning(text)", "warning", "daemon/alarms/alarms.cpp", "alarm "),
        ("info(text)", "info", "daemon/alarms/alarms.cpp", " has returned, not acknowledged"),
        ("info(text)", "info", "daemon/alarms/alarms.cpp", " has returned"),
        ("info(event.text", "info", "daemon/alarms/alarms.cpp", " acknowledged by "),
    ],
    "daemon/estimate/device_lines.cpp": [
        ("write(level, line", "warning", "daemon/estimate/device_lines.cpp", " times by now)"),
        ("write(level, line", "warning", "daemon/estimate/device_lines.cpp", " stale, "),
        ("write(level, line", "info", "core/stream/record.cpp", "end of data"),
        ("info(line", "info", "daemon/estimate/device_lines.cpp", " delivering"),
        ("info(line", "info", "daemon/estimate/device_lines.cpp", " delivering again after "),
        ('warning("device " + device_ + words', "warning", "daemon/estimate/device_lines.cpp",
         "of its polls began too late and were skipped in the last minute"),
    ],
    "daemon/gpio/panel.cpp": [
        ("write(level ?", "info", "daemon/gpio/panel.cpp", "interlock"),
        ("write(level ?", "warning", "daemon/gpio/panel.cpp", "interlock"),
    ],
    "daemon/log/driver_lines.cpp": [
        ("write(level_of(level)", "warning", "daemon/log/driver_lines.cpp", "device "),
    ],
    "daemon/outlets/log_lines.cpp": [
        ("finished_line", "info", "daemon/report/dwell_line.cpp", " complete ("),
        ("finished_line", "info", "daemon/report/dwell_line.cpp", "never settled"),
        ("finished_line", "warning", "daemon/report/dwell_line.cpp", " complete ("),
        ("state_line", "info", "daemon/report/dwell_line.cpp", "state "),
    ],
    "daemon/record/housekeeper.cpp": [
        ("std::move(line)", "warning", "daemon/record/run_audits.cpp", " is tampered with: "),
    ],
    "daemon/record/readiness.cpp": [
        ("text, cut_off->run", "warning", "daemon/record/readiness.cpp", " was cut off"),
    ],
    "daemon/record/recorder.cpp": [
        ("event.text", "error", "daemon/record/recorder.cpp", " events are lost: more than "),
        ("event.text", "error", "daemon/record/recorder.cpp", " results are lost: the recorder fell behind"),
        ("failure", "error", "daemon/record/run_folder.cpp", " could not be closed: "),
    ],
    "daemon/record/run_deleter.cpp": [
        ("tell_(notice)", "info", "daemon/record/run_deleter.cpp", " deleted, "),
        ("tell_(notice)", "warning", "daemon/record/run_deleter.cpp", " could not be deleted"),
    ],
    "daemon/record/run_log.cpp": [
        ("event.text", "error", "daemon/record/run_log.cpp", " here is not recorded: it has "),
        ("Grade::error, text, 0", "error", "daemon/record/run_log.cpp", " records of the stream are lost"),
        ("Grade::info, text", "info", "daemon/record/run_log.cpp", " ended: "),
    ],
    "daemon/run/operator_requests.cpp": [
        ("told.event.text", "info", "daemon/run/operator_requests.cpp", " started"),
        ("told.event.text", "info", "daemon/run/operator_requests.cpp", "run stopped"),
        ("told.event.text", "info", "daemon/run/operator_requests.cpp", "run labelled"),
        ("told.event.text", "info", "daemon/run/operator_requests.cpp", "dwell re-armed"),
    ],
    "daemon/run/recording.cpp": [("notice.text", None, None, None)],  # the notices of the record, each found by itself
    "daemon/run/session.cpp": [
        ("warning(note)", "warning", "config/describe.cpp", " Hz, near a whole multiple of "),
        ("warning(note)", "warning", "config/describe.cpp", " Hz at most: choose a higher baud"),
        ("info(note)", "info", "config/describe.cpp", "; rate_shift = false forbids it"),
    ],
    "daemon/service.cpp": [("config::to_string(", "error", "config/mistake.cpp", ": ")],
}
CALL = re.compile(r"\blog_?(?:\.|->)(?:(info|warning|error)|write)\((?!\))|\btell_?\((?=\s*\{\s*Notice::Grade::(\w+)|notice)")
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"')


def calls(text):
    for found in CALL.finditer(text):
        depth, at = 1, found.end()
        while depth:
            if text[at] == '"':
                at = LITERAL.match(text, at).end()
                continue
            depth += {"(": 1, ")": -1}.get(text[at], 0)
            at += 1
        yield found.group(1) or found.group(2), text[found.start():at]


def words_of(call):
    joined = re.sub(r'"\s*\n\s*"', "", call)
    literals = [one.replace('\\"', '"') for one in LITERAL.findall(joined) if not one.startswith("DWELL_")]
    return [one for one in literals if len(one.strip(' "')) >= 3 and one.strip() != "device"]


def examples(page):
    section = page.split("\n.SH LOG\n")[1].split("\n.SH ")[0]
    for level, line in re.findall(r"^\.B (info|warning|error)\n(.*)$", section, re.M):
        yield level, line.replace("\\-", "-").replace("\\(+-", "±").replace("\\(pc", "·").replace("\\(dq", '"').replace("\\&", "")


def main(folder):
    documented = list(examples((folder / "docs/man/dwelld.8").read_text()))
    seen, faults = set(), []

    def look(level, words, place):
        fitting = [one for one in documented if one[0] == level and all(word in one[1] for word in words)]
        if not fitting:
            faults.append(f"{place}: dwelld.8 has no example of {level}: {' … '.join(words)}")
        seen.update(fitting)

    for path in sorted((folder / "daemon").rglob("*.[ch]pp")):
        name = path.relative_to(folder).as_posix()
        if name.startswith(("daemon/ctl/", "daemon/handon/", "daemon/log/log.")):
            continue
        entries = INDIRECT.get(name, [])
        used = set()
        for level, call in calls(path.read_text()):
            indirect = [entry for entry in entries if entry[0] in re.sub(r"\s+", " ", call)]
            used.update(indirect)
            for _, its_level, source, words in indirect:
                if source is None:
                    continue
                if words not in (folder / source).read_text():
                    faults.append(f"{name}: {source} no longer says {words}")
                look(its_level, [words], name)
            if indirect:
                continue
            words = words_of(call)
            if not words:
                faults.append(f"{name}: {call}: its words stand elsewhere; expected an entry in INDIRECT")
            elif "?" in LITERAL.sub("", call):
                for one in words:
                    look(level, [one], name)
            else:
                look(level, words, name)
        faults += [f"{name}: no call says {entry[0]}" for entry in entries if entry not in used]
    faults += [f"dwelld.8: no call logs this {level}: {line}" for level, line in documented if (level, line) not in seen]
    print("\n".join(faults) or f"{len(documented)} examples")
    return 1 if faults else 0


sys.exit(main(pathlib.Path(sys.argv[1])))
