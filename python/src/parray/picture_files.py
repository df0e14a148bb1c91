"""Writes a PNG picture in other formats: PDF without any library, and those of Pillow."""

from __future__ import annotations

import importlib.util
import io
import struct
from collections.abc import Iterator
from pathlib import Path

from .errors import InputError

_DPI = 300.0  # of a picture that does not state it
_OF_PILLOW = (".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".jp2", ".bmp")


def save_png_as(png: bytes, path: Path) -> None:
    """Writes the pixels of a PNG file in the format of the extension. Raises InputError for extensions that are not known,
    and if Pillow is missing."""
    extension = path.suffix.lower()
    if extension == ".pdf":
        path.write_bytes(pdf_bytes(png, path))
        return
    if extension not in _OF_PILLOW:
        raise InputError(f"{path}: unknown extension: use .exr, .png, .npy, .pdf, {', '.join(_OF_PILLOW)}")
    if importlib.util.find_spec("PIL") is None:
        raise InputError(
            f"{path}: {extension} needs Pillow, which is not installed: pip install pillow, or save as .png or .pdf"
        )
    from PIL import Image, features

    if extension == ".jp2" and not features.check("jpg_2000"):
        raise InputError(f"{path}: this Pillow cannot write JPEG 2000: save as .png or .tif")
    dpi = _dpi_of(png)
    with Image.open(io.BytesIO(png)) as picture:
        if extension in (".jpg", ".jpeg"):
            if picture.mode == "RGBA":
                raise InputError(f"{path}: JPEG has no transparency: save as .png or .tif")
            picture.save(path, quality=95, subsampling=0, dpi=(dpi, dpi))
        elif extension in (".tif", ".tiff"):
            picture.save(path, compression="tiff_deflate", dpi=(dpi, dpi))
        else:
            picture.save(path, **({"lossless": True} if extension == ".webp" else {}))


def pdf_bytes(png: bytes, path: Path) -> bytes:
    """Returns a PDF page that contains the pixels of a PNG file without loss. Its size is that of the picture in print.

    PDF reads the compressed rows of PNG as they are (ISO 32000-1, 7.4.4.4, predictor 15)."""
    chunks = list(_chunks(png))
    width, height, depth, color_type, _, _, interlaced = struct.unpack(">2I5B", chunks[0][1])
    if (depth, color_type, interlaced) != (8, 2, 0):
        raise InputError(f"{path}: only opaque pictures can be saved as PDF: save as .png or .tif")
    data = b"".join(content for kind, content in chunks if kind == b"IDAT")
    points = 72 / _dpi_of(png)
    page = f"{width * points:.4f} 0 0 {height * points:.4f} 0 0 cm /P Do".encode()
    image = (
        f"/Type /XObject /Subtype /Image /Width {width} /Height {height} /ColorSpace /DeviceRGB /BitsPerComponent 8 "
        f"/Filter /FlateDecode /DecodeParms << /Predictor 15 /Colors 3 /Columns {width} >>"
    )
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width * points:.4f} {height * points:.4f}] "
        "/Resources << /XObject << /P 5 0 R >> >> /Contents 4 0 R >>".encode(),
        b"<< /Length %d >> stream\n%s\nendstream" % (len(page), page),
        b"<< %s /Length %d >> stream\n%s\nendstream" % (image.encode(), len(data), data),
    ]
    return _pdf_file(objects)


def _pdf_file(objects: list[bytes]) -> bytes:
    """Returns a PDF file of numbered objects, of which the first is the catalog."""
    out = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n"
    places = []
    for number, content in enumerate(objects, 1):
        places.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, content)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    end = b"trailer << /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, len(out))
    return out + b"xref\n0 %d\n0000000000 65535 f \n%s" % (len(objects) + 1, table) + end


def _chunks(png: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 8
    while at + 8 <= len(png):
        (size,) = struct.unpack_from(">I", png, at)
        yield png[at + 4 : at + 8], png[at + 8 : at + 8 + size]
        at += size + 12


def _dpi_of(png: bytes) -> float:
    """Returns the pixels per inch that the file states, otherwise 300."""
    for kind, content in _chunks(png):
        if kind == b"pHYs":
            across, _, per_metre = struct.unpack(">2IB", content)
            if per_metre and across:
                return float(across * 0.0254)
    return _DPI
