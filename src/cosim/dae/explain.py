"""Tells what the compiler did with a model: sizes at each stage, states, blocks, tearing variables, events."""

from __future__ import annotations

from cosim.dae.dae import Dae


def explain(dae: Dae) -> str:
    """A text of a page or two; what ``cosim export --explain`` prints."""
    sizes = dae.sizes
    lines = [
        f"{dae.name}: {dae.description or 'no description'}",
        "",
        f"equations            {sizes.flat} flat, {sizes.after_aliases} after alias elimination, "
        f"{sizes.differentiated} with derivatives of constraints",
        f"differentiation index  {sizes.index}",
        f"continuous states    {len(dae.states)}",
    ]
    lines += [f"    {state.name}" for state in dae.states]
    lines.append(f"torn unknowns        {len(dae.torn)} (found by the solver together with the states)")
    lines += [f"    {unknown.name}" for unknown in dae.torn]
    explicit = sum(block.kind == "explicit" for block in dae.blocks)
    lines.append(f"blocks               {len(dae.blocks)}, {explicit} of them one explicit assignment each")
    for block in dae.blocks:
        if block.kind == "explicit":
            continue
        how = f"torn in {', '.join(block.torn)}" if block.torn else "solved symbolically"
        shown = ", ".join(block.unknowns[:8]) + (" ..." if len(block.unknowns) > 8 else "")
        lines.append(f"    {block.kind}, {len(block.unknowns)} unknowns, {how}: {shown}")
    lines.append(f"relations            {len(dae.relations)} (their changes are state events)")
    lines += [f"    {relation.text}" for relation in dae.relations]
    lines.append(f"sample clocks        {len(dae.clocks)}")
    lines.append(f"discrete variables   {len(dae.discretes)}")
    lines.append("initial system")
    lines += [f"    {text}" for text in dae.initial_texts]
    lines.append(f"eliminated aliases   {len(dae.aliases)}")
    lines += [f"    {name} = {value}" for name, value in dae.aliases.items()]
    return "\n".join(lines)
