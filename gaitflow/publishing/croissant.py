"""A dataset's metadata in Croissant 1.1, which dataset catalogues and loaders read."""

from __future__ import annotations

import json
from typing import Any

from gaitflow.publishing import citation
from gaitflow.publishing.dataset_facts import DatasetFacts, Field, Table

FILE = "croissant.json"
TYPES = {"string": "sc:Text", "bool": "sc:Boolean", "int64": "sc:Integer", "float64": "sc:Float"}
# The context that the specification gives.
_TERMS = (
    "arrayShape", "citeAs", "column", "containedIn", "equivalentProperty", "extract", "field", "fileProperty",
    "fileObject", "fileSet", "format", "includes", "isArray", "isLiveDataset", "jsonPath", "key", "md5", "parentField",
    "path", "recordSet", "references", "regex", "repeated", "replace", "samplingRate", "separator", "source",
    "subField", "transform",
)  # fmt: skip
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "sc": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{term: f"cr:{term}" for term in _TERMS},
}


def croissant(facts: DatasetFacts) -> str:
    """The JSON-LD document, whose files are named relative to it."""
    data = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.1",
        "name": facts.name,
        "version": facts.version,
        "description": facts.scenario["description"] or f"Solved gaits and labels of {facts.name}.",
        "datePublished": facts.created[:10],
        "license": citation.LICENCE_ADDRESS,
        "citeAs": citation.PAPER,
        "creator": {"@type": "sc:Organization", "name": citation.MAINTAINERS},
        "distribution": [_file(table) for table in facts.tables],
        "recordSet": [_records(table) for table in facts.tables],
    }
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


def _file(table: Table) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": table.file,
        "name": table.file,
        "description": f"A row: {table.row}.",
        "contentUrl": table.file,
        "contentSize": f"{table.entry.bytes} B",
        "encodingFormat": "application/x-parquet",
        "sha256": table.entry.sha256,
    }


def _records(table: Table) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": table.name,
        "name": table.name,
        "description": f"A record: {table.row}.",
        "field": [_field(table, field) for field in table.fields],
    }


def _field(table: Table, field: Field) -> dict[str, Any]:
    unit = f" [{field.column.unit}]" if field.column.unit else ""
    shape = {"isArray": True, "arrayShape": ",".join(map(str, field.shape))} if field.shape else {}
    return {
        "@type": "cr:Field",
        "@id": f"{table.name}/{field.name}",
        "name": field.name,
        "description": f"{field.column.meaning}{unit}",
        "dataType": TYPES.get(field.type, "sc:Text"),
        **shape,
        "source": {"fileObject": {"@id": table.file}, "extract": {"column": field.name}},
    }
