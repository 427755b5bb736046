//! Extraction of polygon meshes: masks against sums over faces.
