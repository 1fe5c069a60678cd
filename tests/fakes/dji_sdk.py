"""A library with the interface of DJI's Thermal SDK, whose temperatures say under which conditions they were asked for.

A photograph of it is any JPEG file in which ``DJI`` stands, and one of the marks below.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

WIDTH_PX, HEIGHT_PX = 64, 48
RADIOMETRIC, PICTURE, CRASHING, COLD = b"FAKE:T", b"FAKE:P", b"FAKE:C", b"FAKE:0"
RECORDED = {"distance": 5.0, "humidity": 70.0, "emissivity": 0.95, "reflected": 23.0, "air": 15.0}

_SOURCE = r"""
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef CONDITIONS
#define CONDITIONS 5
#endif
#ifndef OPENING
#define OPENING 0
#endif

typedef struct { char kind; float values[CONDITIONS]; } photograph;
static const float recorded[] = {5.0f, 70.0f, 0.95f, 23.0f, 15.0f};
static const float limits[] = {1.0f, 25.0f, 20.0f, 100.0f, 0.1f, 1.0f, -40.0f, 500.0f, -40.0f, 80.0f};

int32_t dirp_create_from_rjpeg(const uint8_t *data, int32_t size, void **handle) {
    printf("It talks to those who made it.\n");
    if (OPENING) return OPENING;
    for (int32_t at = 0; at + 6 <= size; at++) {
        if (memcmp(data + at, "FAKE:", 5)) continue;
        if (data[at + 5] == 'P') return -7;
        if (data[at + 5] == 'C') abort();
        photograph *one = malloc(sizeof *one);
        one->kind = (char)data[at + 5];
        memcpy(one->values, recorded, sizeof one->values);
        *handle = one;
        return 0;
    }
    return -7;
}

int32_t dirp_destroy(void *handle) { free(handle); return 0; }

int32_t dirp_get_rjpeg_resolution(void *handle, int32_t *size) { size[0] = 64; size[1] = 48; return 0; }

int32_t dirp_get_measurement_params(photograph *one, float *values) {
    memcpy(values, one->values, sizeof one->values);
    return 0;
}

int32_t dirp_get_measurement_params_range(void *handle, float *values) {
    memcpy(values, limits, 2 * CONDITIONS * sizeof(float));
    return 0;
}

int32_t dirp_set_measurement_params(photograph *one, const float *values) {
    if (values[0] == 13.0f) return -3;
    memcpy(one->values, values, sizeof one->values);
    return 0;
}

int32_t dirp_measure_ex(photograph *one, float *celsius, int32_t size) {
    if (size != 64 * 48 * (int32_t)sizeof(float)) return -8;
    for (int i = 0; i < 64 * 48; i++) celsius[i] = one->kind == '0' ? -273.15f : 0.0f;
    if (one->kind == '0') return 0;
    for (int i = 0; i < 64 * 48; i++) celsius[i] = i < CONDITIONS ? one->values[i] : 20.0f + 0.01f * (float)i;
    return 0;
}
"""


def build(folder: Path, *options: str) -> Path:
    """Compile the library into a folder, and return it."""
    compiler = shutil.which("cc")
    assert compiler is not None
    folder.mkdir(parents=True, exist_ok=True)
    source, library = folder / "dirp.c", folder / "libdirp.so"
    source.write_text(_SOURCE)
    command = [compiler, "-shared", "-fPIC", "-o", str(library), str(source), *options]
    subprocess.run(command, check=True)  # noqa: S603
    return library


def photograph(mark: bytes) -> bytes:
    """Return the beginning of a photograph."""
    return b"\xff\xd8\xff\xe1\x00\x18DJI " + mark


def insert(path: Path, mark: bytes) -> None:
    """Make a photograph one of the library's."""
    content = path.read_bytes()
    comment = b"DJI " + mark
    path.write_bytes(content[:2] + b"\xff\xfe" + (len(comment) + 2).to_bytes(2, "big") + comment + content[2:])


def celsius(**conditions: float) -> NDArray[np.float32]:
    """Return the temperatures of a photograph under conditions that replace the recorded ones."""
    pixels = 20.0 + 0.01 * np.arange(WIDTH_PX * HEIGHT_PX, dtype=np.float32)
    pixels[: len(RECORDED)] = list((RECORDED | conditions).values())
    return pixels.reshape(HEIGHT_PX, WIDTH_PX)
