"""
10. Taking apart
================

Which bodies may go now, in which order, and with the fewest removals to a certain one.
"""

import sys
from pathlib import Path

import holdfast as hf

out = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

assembly = hf.assemble(hf.shipped_scene("cantilever"))  # Fig. 16 of the paper
d = hf.disassembly_order(assembly)
print(f"one by one: {', '.join(d.order)}; put together again: {', '.join(d.assembly_order)}")
for removal in d.answers():
    print(f"  {removal.body} now: {removal.answer} ({removal.reason})")
for row in d.paper_table():
    print(f"  paper's test of {row.body}: R {row.force:.2f} N against its weight {row.weight:.2f} N")
d.save_png(out / "cantilever.png")

arch = hf.disassembly_order(hf.assemble(hf.shipped_scene("arch")))
print(f"arch: {arch.order or 'no body may go'}; v3: {arch.blocked['v3']}")

wall = hf.assemble(hf.shipped_scene("wall2x2"))
b = hf.disassembly_order(wall, goal="b0_1")
print(f"wall: b0_1 out after {len(b.order)} removals, none fewer than {b.fewest:.0f}: {', '.join(b.order)}")
