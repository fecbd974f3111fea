"""The page of a batch's report: no scripts, and its security policy forbids all network requests."""

from __future__ import annotations

from typing import Final

PAGE: Final = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:">
<title>$title</title>
<style>
body { margin: 0 auto; max-width: 1040px; padding: 18px 22px 60px; color: #14171c; background: #fff;
  font: 15px/1.45 system-ui, "Segoe UI", "DejaVu Sans", Arial, sans-serif; }
h1 { font-size: 23px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 17px; margin: 30px 0 8px; border-bottom: 1px solid #dfe2e7; padding-bottom: 4px; }
h3 { font-size: 14px; margin: 0 0 6px; }
p { margin: 4px 0; color: #59606b; }
figure { margin: 0; }
svg { max-width: 100%; height: auto; }
svg text { font-size: 12px; fill: #59606b; }
.side { display: flex; flex-wrap: wrap; gap: 22px 40px; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 16px; font-size: 14px; max-width: 460px; }
.legend i { display: inline-block; width: 11px; height: 11px; margin-right: 6px; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, 240px); gap: 16px; }
.pictures img { width: 240px; height: 180px; border: 1px solid #dfe2e7; }
.pictures figcaption { font-size: 13px; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th { text-align: left; font-weight: 600; color: #59606b; white-space: nowrap; }
th, td { padding: 3px 14px 3px 0; border-bottom: 1px solid #eef0f3; vertical-align: top; overflow-wrap: break-word; }
td { max-width: 480px; }
</style>
</head>
<body>
<h1>$title</h1>
<p>$subtitle</p>
<h2>How scenes ended</h2>
<div class="side">
<div><h3>outcomes</h3>$outcomes</div>
<div><h3>verdicts</h3>$verdicts</div>
</div>
<h2>Distributions</h2>
<div class="side">$distributions</div>
<h2>The weakest</h2>
<p>Those that do not stand come first, with the bodies that move in red; then the undecided, then by strength.</p>
<div class="pictures">$pictures</div>
$weakest
<h2>Why scenes do not stand, or are undecided</h2>
$reasons
<h2>Not answered</h2>
$failures
<h2>The slowest</h2>
$slowest
</body>
</html>
"""
