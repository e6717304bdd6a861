"""The style of a report's page, light and dark."""

SHEET = """
:root {
  color-scheme: light dark;
  --ground: #f6f5f2; --card: #ffffff; --ink: #1c2227; --soft: #5c676f; --rule: #e3e1dc;
  --hover: #faf9f7; --good: #2f7d4f; --bad: #b3372f;
  --arm0: #0f6b8f; --arm1: #c85a11; --arm2: #6a4fb3; --arm3: #2f7d4f; --arm4: #b02a5b;
  --arm5: #7c6a0a;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ground: #14181b; --card: #1c2226; --ink: #e8eaeb; --soft: #9ba7ae; --rule: #323a40;
    --hover: #222a2f; --good: #6cc590; --bad: #f0857c;
    --arm0: #5ab9de; --arm1: #f29b57; --arm2: #b09bf0; --arm3: #7ccf9c; --arm4: #f084ab;
    --arm5: #d6c155;
  }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 940px; margin: 0 auto; padding: 48px 20px 80px; }
h1 { font-size: 34px; line-height: 1.15; letter-spacing: -0.02em; margin: 0 0 10px; }
h2 { font-size: 20px; letter-spacing: -0.01em; margin: 0 0 4px; }
h3 { font-size: 14px; margin: 0 0 2px; }
p { margin: 0 0 14px; max-width: 68ch; }
.lead { font-size: 17px; color: var(--soft); margin-bottom: 24px; }
.soft, figcaption, td.soft { color: var(--soft); }
section { background: var(--card); border: 1px solid var(--rule); border-radius: 12px;
  padding: 26px 28px 22px; margin: 18px 0; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(210px, 1fr)); gap: 14px; }
.card { background: var(--card); border: 1px solid var(--rule); border-radius: 12px;
  padding: 18px 20px; border-top: 4px solid var(--rule); }
.card b { display: block; font-size: 34px; line-height: 1.2; letter-spacing: -0.02em;
  font-weight: 650; }
.card .soft { font-size: 13px; display: block; }
.scroll { overflow-x: auto; }
summary { cursor: pointer; color: var(--arm0); margin-top: 14px; }
table { border-collapse: collapse; width: 100%; font-size: 14px;
  font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; color: var(--soft); font-size: 12.5px; }
th, td { padding: 7px 12px 7px 0; border-bottom: 1px solid var(--rule); vertical-align: top; }
tbody tr:last-child td { border-bottom: 0; }
tbody tr:hover { background: var(--hover); }
th.n, td.n { text-align: right; } td.n, .arm-name { white-space: nowrap; }
td.n:last-child, th.n:last-child { padding-right: 0; }
a { color: var(--arm0); text-decoration: none; }
a:hover { text-decoration: underline; }
code { font: 12.5px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace;
  overflow-wrap: anywhere; }
pre { background: var(--ground); border: 1px solid var(--rule); border-radius: 8px;
  padding: 12px 14px; overflow-x: auto; margin: 0 0 14px; }
.dot { display: inline-block; width: 10px; height: 10px; border-radius: 50%; margin-right: 8px; }
.bar { display: inline-block; height: 8px; border-radius: 4px; min-width: 2px;
  vertical-align: 1px; margin-right: 8px; }
.once { white-space: nowrap; margin-right: 10px; } .once .dot { margin-right: 5px; }
.good { color: var(--good); } .bad { color: var(--bad); }
svg { max-width: 100%; height: auto; display: block; overflow: visible; }
svg text { fill: var(--ink); font-size: 13px; }
svg .name { text-anchor: end; } svg .note { fill: var(--soft); }
svg .tick { fill: var(--soft); font-size: 11.5px; text-anchor: middle; }
svg .tick.end { text-anchor: end; }
svg .grid { stroke: var(--rule); fill: none; }
svg .half { stroke: var(--soft); stroke-dasharray: 3 4; fill: none; }
svg .span { stroke-width: 3; stroke-linecap: round; } svg .thin { stroke-width: 1.5; opacity: 0.5; }
svg .line { stroke-width: 2; fill: none; } svg .faint { opacity: 0.45; stroke: none; }
.several { display: grid; grid-template-columns: repeat(auto-fill, minmax(240px, 1fr));
  gap: 22px 20px; margin-top: 14px; }
figure { margin: 0; } figcaption { font-size: 12.5px; line-height: 1.5; margin-top: 2px; }
ARMS
@media print { body { background: none; } section, .card { break-inside: avoid; } }
"""

N_COLOURS = 6

_ARM = """.arm{k} {{ stroke: var(--arm{k}); }}
.arm{k}.solid, .arm{k}.faint {{ fill: var(--arm{k}); }}
.dot.arm{k}, .bar.arm{k} {{ background: var(--arm{k}); }}
.card.arm{k} {{ border-top-color: var(--arm{k}); }}"""


def sheet() -> str:
    """Return the CSS, with each system's colour."""
    return SHEET.replace("ARMS", "\n".join(_ARM.format(k=k) for k in range(N_COLOURS)))
