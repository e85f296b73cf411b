"""What a training says of itself: a line of JSON per log interval and evaluation, curves as a picture, a progress bar."""
import json
import sys
import time

_COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b")


class Journal:
    """Appends to log.jsonl; entries after the step that is gone on from are dropped."""

    def __init__(self, path, resumed_step=0):
        self.path = path
        self.entries = []
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                try:
                    entry = json.loads(line)
                except ValueError:
                    continue  # cut short by a stop
                if entry["step"] <= resumed_step:
                    self.entries.append(entry)
            path.write_text("".join(json.dumps(e) + "\n" for e in self.entries), encoding="utf-8")

    def add(self, entry):
        self.entries.append(entry)
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")

    def series(self):
        """{name: [(step, value)]} of all numbers."""
        out = {}
        for entry in self.entries:
            for name, value in entry.items():
                if name != "step" and isinstance(value, (int, float)):
                    out.setdefault(name, []).append((entry["step"], value))
        return out


def draw_curves(series, path, names, unit="step"):
    """A picture with one panel per name; a name "a b" draws both into one; of "title:a" the title stands first.
    unit: of what the points stand over."""
    from PIL import Image, ImageDraw

    width, height, margin = 640, 200, 46
    picture = Image.new("RGB", (width, height * len(names)), "white")
    draw = ImageDraw.Draw(picture)
    for panel, group in enumerate(names):
        lines = [(name, series[name]) for name in group.split() if len(series.get(name, ())) > 1]
        top = panel * height
        if not lines:
            draw.text((margin, top + 4), f"{group}: nothing yet", fill="black")
            continue
        values = sorted(v for _, points in lines for _, v in points)
        low, high = values[0], values[min(len(values) - 1, int(len(values) * 0.98))]
        span = max(high - low, 1e-9)
        last = max(points[-1][0] for _, points in lines)
        first = min(points[0][0] for _, points in lines)

        def at(step, value):
            x = margin + (width - 2 * margin) * (step - first) / max(last - first, 1)
            y = top + height - 24 - (height - 48) * min(max((value - low) / span, 0), 1)
            return x, y

        for tick in range(5):
            value = low + span * tick / 4
            y = at(first, value)[1]
            draw.line([(margin, y), (width - margin, y)], fill="#dddddd")
            draw.text((2, y - 6), f"{value:.3g}", fill="black")
        draw.text((width - 2 * margin, top + height - 20), f"{unit} {last}", fill="black")
        title = lines[0][0].rpartition(":")[0]
        draw.text((margin, top + 4), title, fill="black")
        legend = margin + (draw.textlength(title) + 20 if title else 0)
        for i, (name, points) in enumerate(lines):
            colour = _COLOURS[i % len(_COLOURS)]
            draw.line([at(*p) for p in points], fill=colour, width=2)
            label = name.rpartition(":")[2]
            draw.text((legend, top + 4), label, fill=colour)
            legend += draw.textlength(label) + 20
    picture.save(path)


class Progress:
    """A bar on stderr, only where that is a terminal."""

    def __init__(self, what, total):
        self._what, self._total, self._start, self._first = what, total, time.monotonic(), None
        self._shown = sys.stderr.isatty()

    def show(self, done, note=""):
        if not self._shown:
            return
        if self._first is None:
            self._first = done
        elapsed = time.monotonic() - self._start
        rate = (done - self._first) / elapsed if elapsed > 0 else 0
        left = int((self._total - done) / rate) if rate > 0 else 0
        filled = 30 * done // max(self._total, 1)
        bar = "#" * filled + "." * (30 - filled)
        print(f"\r\x1b[K{self._what} [{bar}] {done}/{self._total}  {left // 3600}:{left // 60 % 60:02}:{left % 60:02} left  {note}",
              end="", file=sys.stderr, flush=True)

    def end(self):
        if self._shown:
            print(file=sys.stderr)
