"""Bar charts and histograms as SVG, without a library."""

from xml.sax.saxutils import escape

COLOURS = ["#1f6f8b", "#d1793b", "#7a9e3f", "#8a5a9e", "#999999"]
FONT = 'font-family="sans-serif" font-size="12"'
WIDTH = 760
LABELS = 190


def _svg(height, parts, title):
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
        f'<text x="10" y="18" font-weight="bold" {FONT}>{escape(title)}</text>',
        *parts, "</svg>", ""])


def _number(value):
    if value >= 100:
        return f"{value:,.0f}"
    return f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def bars(title, rows, series, marker=None):
    """Horizontal bars: `rows` of (label, [a value or None for each of `series`])."""
    bar, gap = 13, 10
    values = [value for _, row in rows for value in row if value is not None]
    largest = max(values + ([marker] if marker else []))
    scale = (WIDTH - LABELS - 80) / largest
    parts = []
    x = LABELS
    for index, name in enumerate(series):
        parts.append(f'<rect x="{x}" y="28" width="11" height="11" fill="{COLOURS[index]}"/>')
        parts.append(f'<text x="{x + 15}" y="38" {FONT}>{escape(name)}</text>')
        x += 30 + 7 * len(name)
    y = 52
    top = y
    for label, row in rows:
        middle = y + bar * len(series) / 2 + 4
        parts.append(f'<text x="{LABELS - 8}" y="{middle:.0f}" text-anchor="end" {FONT}>'
                     f"{escape(label)}</text>")
        for index, value in enumerate(row):
            if value is not None:
                width = max(value * scale, 1)
                parts.append(f'<rect x="{LABELS}" y="{y}" width="{width:.1f}" '
                             f'height="{bar - 2}" fill="{COLOURS[index]}"/>')
                parts.append(f'<text x="{LABELS + width + 4:.1f}" y="{y + 10}" {FONT}>'
                             f"{_number(value)}</text>")
            y += bar
        y += gap
    if marker:
        x = LABELS + marker * scale
        parts.append(f'<line x1="{x:.1f}" y1="{top - 6}" x2="{x:.1f}" y2="{y}" '
                     'stroke="#c00000" stroke-dasharray="4 3"/>')
    return _svg(y + 8, parts, title)


def histogram(title, counts, bucket, unit, marks):
    """`counts` of buckets that are `bucket` wide; `marks`: (label, value) on the same axis."""
    height, bottom = 260, 220
    end = max([len(counts) * bucket] + [value for _, value in marks]) * 1.02
    scale = (WIDTH - 90) / end
    largest = max(counts) or 1
    parts = []
    for index, count in enumerate(counts):
        if count:
            tall = max(count / largest * 160, 1)
            parts.append(f'<rect x="{60 + index * bucket * scale:.1f}" y="{bottom - tall:.1f}" '
                         f'width="{max(bucket * scale - 1, 1):.1f}" height="{tall:.1f}" '
                         f'fill="{COLOURS[0]}"/>')
    parts.append(f'<line x1="60" y1="{bottom}" x2="{WIDTH - 30}" y2="{bottom}" stroke="#000"/>')
    for step in range(6):
        value = end * step / 5
        parts.append(f'<text x="{60 + value * scale:.1f}" y="{bottom + 16}" '
                     f'text-anchor="middle" {FONT}>{_number(value)}</text>')
    parts.append(f'<text x="{WIDTH - 30}" y="{bottom + 34}" text-anchor="end" {FONT}>'
                 f"{escape(unit)}</text>")
    for index, (label, value) in enumerate(marks):
        x = 60 + value * scale
        parts.append(f'<line x1="{x:.1f}" y1="40" x2="{x:.1f}" y2="{bottom}" stroke="#c00000" '
                     'stroke-dasharray="4 3"/>')
        parts.append(f'<text x="{x - 4:.1f}" y="{44 + 15 * index}" text-anchor="end" {FONT}>'
                     f"{escape(label)}: {_number(value)}</text>")
    return _svg(height, parts, title)
