# The report as a browser parses it: read_report.py REPORT SHA256_OF_THE_RIG_FILE SHA256_OF_A_FILE SHA256_OF_A_LARGE_FILE.
# Tags balanced, nothing that runs or is fetched, outside text shown as text; the uncertainty budget and the files with
# their sums are there.
import re
import sys
from html.parser import HTMLParser

VOID = {"meta", "br", "link", "img"}


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.seen, self.text = [], {}, []
        self.tables = []  # each its rows, each its cells

    def handle_starttag(self, tag, attributes):
        assert tag in ALLOWED, tag
        for name, value in attributes:
            assert not name.startswith("on"), (tag, name)
            assert name not in {"src", "href", "xlink:href", "action"}, (tag, name)
            assert "url(" not in (value or ""), (tag, value)
        self.seen[tag] = self.seen.get(tag, 0) + 1
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in {"td", "th"}:
            self.tables[-1][-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, (tag, self.open)
        self.open.pop()

    def handle_data(self, data):
        self.text.append(data)
        if "td" in self.open or "th" in self.open:
            self.tables[-1][-1][-1] += data


ALLOWED = set(
    "html head meta title style body main h1 h2 h3 h4 p table thead tbody tr th td ul li figure figcaption svg rect line path"
    " circle text div section code pre strong".split()
)
page = Page()
source = open(sys.argv[1], encoding="utf-8").read()
page.feed(source)
page.close()
assert not page.open, page.open
text = "".join(page.text)
for words in [
    'Run 7: cold <b>start</b> & "quoted"',
    "mount <1>",
    "o'brien",
    "after the <i>service</i>",
    "<script>alert(1)</script>",
    "K-<7>, due 2025-01-31",
    "overdue",
    "240.0",
    "±",
    "intact, key 1234",
    "dwell 1",
    "the ring between driver and estimation was full",
    "reviewed",
]:
    assert words in text or words.capitalize() in text, words
assert page.seen["svg"] >= 3 + 1 + 1, page.seen  # traces, phasors, chain
assert "@import" not in source and "http://" not in source and "https://" not in source


def table(*columns):
    """The rows below these columns."""
    found = [rows for rows in page.tables if rows[0] == list(columns)]
    assert len(found) == 1, (columns, [rows[0] for rows in page.tables])
    return found[0][1:]


# Of the one element: calibrated within 0.5 and 1 permille, little noise. The parts make up the whole.
budget = table("element", "part in u\u00b2(c)", "part in u\u00b2(r)")
assert [row[0] for row in budget] == ["1"], budget
for parts in budget[0][1:]:
    assert abs(sum(float(part) for part in re.findall(r"([\d.e+-]+) %", parts)) - 100) <= 3, parts
assert "scale of reaction" in budget[0][1] and "scale of y0" in budget[0][1], budget

rig_sum, file_sum, large_sum = sys.argv[2:]
assert "rig.toml " + rig_sum in text, rig_sum
files = table("file that the rig file names", "SHA-256", "text")
assert files == [
    ["motor <1>.dbc", file_sum, "in the run file"],
    ["tape.csv", large_sum, "too large for the run file"],
    ["endless.csv", "not known", "too large for the run file"],
], files
