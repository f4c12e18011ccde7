"""Tells catkin where the Python module is; not for use by hand."""
from setuptools import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(packages=["deformable_surface_sweep"], package_dir={"": "src"}))
