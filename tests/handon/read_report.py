# The report as a browser parses it: read_report.py REPORT. Tags balanced, nothing that runs or is fetched, outside text
# shown as text.
import sys
from html.parser import HTMLParser

VOID = {"meta", "br", "link", "img"}


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.seen, self.text = [], {}, []

    def handle_starttag(self, tag, attributes):
        assert tag in ALLOWED, tag
        for name, value in attributes:
            assert not name.startswith("on"), (tag, name)
            assert name not in {"src", "href", "xlink:href", "action"}, (tag, name)
            assert "url(" not in (value or ""), (tag, value)
        self.seen[tag] = self.seen.get(tag, 0) + 1
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


ALLOWED = set(
    "html head meta title style body h1 h2 h3 h4 p table thead tbody tr th td ul li figure figcaption svg rect line path"
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
