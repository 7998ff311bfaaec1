# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Archives that depend on nothing but the files in them and one time: entries are sorted, owners and modes fixed.

A file is a pair (content, is_executable); files are a dictionary by path.
"""
import gzip
import io
import tarfile
import time
import zipfile

# 1980-01-01 and the last second of 2107: a zip holds no earlier or later time.
OLDEST_IN_ZIP = 315532800
LATEST_IN_ZIP = 4354819199


def mode(is_executable):
    return 0o755 if is_executable else 0o644


def tar_gz(files, seconds):
    """The bytes of a .tar.gz. The header of gzip gets no name and no time."""
    packed = io.BytesIO()
    with gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=packed, mtime=0) as zipped:
        with tarfile.open(mode="w", fileobj=zipped, format=tarfile.USTAR_FORMAT) as tar:
            for path, (content, is_executable) in sorted(files.items()):
                entry = tarfile.TarInfo(path)
                entry.size, entry.mtime, entry.mode = len(content), seconds, mode(is_executable)
                tar.addfile(entry, io.BytesIO(content))
    return packed.getvalue()


def zip_archive(files, seconds):
    """The bytes of a .zip, with times in UTC and a precision of 2 s."""
    packed = io.BytesIO()
    date = time.gmtime(max(seconds, OLDEST_IN_ZIP))[:6]
    with zipfile.ZipFile(packed, "w") as archive:
        for path, (content, is_executable) in sorted(files.items()):
            entry = zipfile.ZipInfo(path, date)
            entry.create_system = 3  # Unix: the modes count
            entry.external_attr = (0o100000 | mode(is_executable)) << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()
