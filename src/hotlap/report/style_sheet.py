"""Style sheet: of pages that are read and printed, in light and dark."""

STYLE = """
:root { color-scheme: light dark; --ink: #1d2228; --quiet: #626b75; --line: #d9dde2; --paper: #ffffff; --accent: #0063a6; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ed; --quiet: #9aa4af; --line: #343c46; --paper: #14181d; --accent: #6cb6f0; }
}
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 72rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 1rem; }
h2 { font-size: 1.15rem; margin: 2.5rem 0 0.5rem; }
p, figcaption { max-width: 46rem; }
figcaption { color: var(--quiet); font-size: 0.85rem; margin-top: 0.3rem; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
a { color: var(--accent); }
code { font: 0.9em ui-monospace, monospace; }
.wide { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.3rem 0.9rem 0.3rem 0; text-align: left; border-bottom: 1px solid var(--line); white-space: nowrap; }
thead th { color: var(--quiet); font-weight: 500; }
tbody th { font-weight: 500; }
th.number, td.number { text-align: right; }
@media print {
  :root { --ink: #000000; --quiet: #444444; --line: #bbbbbb; --paper: #ffffff; }
  main { max-width: none; padding: 0; }
  table { font-size: 0.7rem; }
  figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
}
""".strip()
