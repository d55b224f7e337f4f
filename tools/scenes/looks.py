"""Materials that the scenes share."""

def matte(glb, name, base=(1, 1, 1), **more):
    """A Lambert surface: without the 4 % of gloss that glTF gives a dielectric by default."""
    return glb.material(name, base, extensions=dict(KHR_materials_specular=dict(specularFactor=0.0)), **more)


def printed(glb, name, picture, tint=(1, 1, 1), **more):
    """A Lambert surface that wears a picture."""
    return matte(glb, name, tint, textures=glb.texture(name, picture), **more)


def lit(glb, name, strength, color=(1, 1, 1), picture=None, base=(0, 0, 0), **more):
    """A surface that shines with `strength` times its colour, and its picture if it has one; otherwise black."""
    if picture is not None:
        more["emissiveTexture"] = glb.texture(name, picture)
    extensions = dict(KHR_materials_emissive_strength=dict(emissiveStrength=strength),
                      KHR_materials_specular=dict(specularFactor=0.0))
    return glb.material(name, base, emissiveFactor=[float(c) for c in color], extensions=extensions, **more)


def glowing(glb, name, strength, color=(1, 1, 1), **more):
    """A surface that shines as `lit` does and is grey: it sends back half of the light that falls on it, too."""
    return lit(glb, name, strength, color, base=(0.5, 0.5, 0.5), **more)
