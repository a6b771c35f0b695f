"""The published split and the published figures that the tables quote.

Split: C. Liu, M. Fischer, T. Ritschel, "Learning to Learn and Sample BRDFs", Computer Graphics
Forum 42(2), 2023. Their code divides the 100 MERL materials, sorted by name, by a seeded
permutation (seed 42) into 80 to learn from and 20 to test on: `HELD_OUT`.

Figures: F. Gokbudak, A. Sztrajman, C. Zhou, F. Zhong, R. Mantiuk, C. Oztireli, "Hypernetworks
for Generalizable BRDF Representation", ECCV 2024, Table 1: means over 20 held-out materials of
their own split, which is not listed.
"""

from __future__ import annotations

__all__ = ["CITATION", "HELD_OUT", "HYPERBRDF", "SAMPLES"]

CITATION = "HyperBRDF (Gokbudak et al., ECCV 2024, Table 1)"

HELD_OUT = (
    *("alumina-oxide", "aluminium", "blue-rubber", "color-changing-paint1"),
    *("color-changing-paint2", "dark-blue-paint", "gold-metallic-paint2", "green-metallic-paint"),
    *("pickled-oak-260", "pink-fabric", "purple-paint", "red-fabric2", "silver-paint"),
    *("specular-blue-phenolic", "ss440", "teflon", "two-layer-gold", "two-layer-silver"),
    *("white-diffuse-bball", "white-fabric"),
)
"""The 20 materials that nothing may be learnt from."""

SAMPLES = (8, 16, 40, 160, 400, 2000, 4000)
"""Numbers of samples; HyperBRDF has figures from 40 on."""

HYPERBRDF = {
    "MERL": {
        40: {"psnr": 29.581, "perceptual_error": 3.189, "ssim": 0.968},
        160: {"psnr": 31.341, "perceptual_error": 2.681, "ssim": 0.973},
        400: {"psnr": 32.743, "perceptual_error": 2.272, "ssim": 0.979},
        2000: {"psnr": 34.527, "perceptual_error": 2.256, "ssim": 0.979},
        4000: {"psnr": 33.170, "perceptual_error": 2.138, "ssim": 0.977},
    },
    "MERL+RGL": {
        40: {"psnr": 30.018, "perceptual_error": 3.112, "ssim": 0.963},
        160: {"psnr": 31.929, "perceptual_error": 2.454, "ssim": 0.962},
        400: {"psnr": 33.855, "perceptual_error": 2.432, "ssim": 0.977},
        2000: {"psnr": 34.527, "perceptual_error": 2.243, "ssim": 0.983},
        4000: {"psnr": 34.355, "perceptual_error": 2.166, "ssim": 0.982},
    },
}
"""Materials that it learnt from -> number of samples -> metric -> figure as printed."""
