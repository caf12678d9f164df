"""Pieces of system structures and parameter sets, as a person would write them."""

from __future__ import annotations

HEAD = (
    '<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" version="1.0" name="test">'
)
UNITS = (
    '<ssd:Units><ssc:Unit name="m/s"><ssc:BaseUnit m="1" s="-1"/></ssc:Unit>'
    '<ssc:Unit name="km/h"><ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit>'
    '<ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit><ssc:Unit name="V">'
    '<ssc:BaseUnit kg="1" m="2" s="-3" A="-1"/></ssc:Unit></ssd:Units>'
)
SSV = (
    '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="set"><ssv:Parameters>{}'
    "</ssv:Parameters>{}</ssv:ParameterSet>"
)
SSM = (
    '<ssm:ParameterMapping xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0">{}</ssm:ParameterMapping>'
)


def ssd(system: str, after: str = UNITS) -> str:
    """Return an SSD around the inside of its system."""
    return f'{HEAD}<ssd:System name="root">{system}</ssd:System>{after}</ssd:SystemStructureDescription>'


def connector(name: str, kind: str, type_: str = "", unit: str = "") -> str:
    inner = f'<ssc:{type_}{f""" unit="{unit}" """ if unit else ""}/>' if type_ else ""
    return f'<ssd:Connector name="{name}" kind="{kind}">{inner}</ssd:Connector>'


def element(name: str, connectors: str, source: str = "resources/integrator.fmu", bindings: str = "") -> str:
    return (
        f'<ssd:Component name="{name}" source="{source}"><ssd:Connectors>{connectors}</ssd:Connectors>'
        f"{bindings}</ssd:Component>"
    )


def link(start: str, end: str, inner: str = "", more: str = "") -> str:
    """Return a connection of ends such as ``car.v``, or ``v`` for a connector of the system."""

    def ends(which: str, text: str) -> str:
        owner, _, name = text.rpartition(".")
        return (f'{which}Element="{owner}" ' if owner else "") + f'{which}Connector="{name}" '

    return f"<ssd:Connection {ends('start', start)}{ends('end', end)}{more}>{inner}</ssd:Connection>"


def wrapped(tag: str, *inner: str) -> str:
    return f"<ssd:{tag}>{''.join(inner)}</ssd:{tag}>"


def real(name: str, value: float | str, unit: str = "") -> str:
    attribute = f' unit="{unit}"' if unit else ""
    return f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"{attribute}/></ssv:Parameter>'


KMH = '<ssv:Units><ssc:Unit name="km/h"><ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit></ssv:Units>'


def inline(*parameters: str, units: str = "", mapping: str = "", prefix: str = "") -> str:
    values = SSV.format("".join(parameters), units)
    mapped = f"<ssd:ParameterMapping>{SSM.format(mapping)}</ssd:ParameterMapping>" if mapping else ""
    attribute = f' prefix="{prefix}"' if prefix else ""
    inner = f"<ssd:ParameterValues>{values}</ssd:ParameterValues>{mapped}"
    return f"<ssd:ParameterBinding{attribute}>{inner}</ssd:ParameterBinding>"
