// A quarter of a ball of radius 10 mm above a quarter of a thick plate, x >= 0, y >= 0; they touch at the origin [m].
//   gmsh -3 -format msh41 ball_on_plate.geo -o ball_on_plate.msh
// Tetrahedra with edges of 0.16 mm out to `touching`, farther away growing by `growth` per length up to 2 mm; those of
// the plate are a tenth longer. `-setnumber refinement 2` halves every edge. The cap of the ball, 0.3 rad, and `patch`
// of the plate are the surfaces that may touch.
SetFactory("OpenCASCADE");
DefineConstant[ refinement = 1 ];
radius = 0.010; cap = radius * (1 - Cos(0.3)); patch = 0.003; plate = 0.020; touching = 0.0011; growth = 0.2;
fine = 0.12e-3 / refinement; coarse = 1.25e-3 / refinement;

Sphere(1) = {0, 0, radius, radius, -Pi / 2, Pi / 2, Pi / 2};
Box(2) = {0, 0, 0, radius, radius, cap};
Box(3) = {0, 0, -plate, plate, plate, plate};
Box(4) = {0, 0, -patch, patch, patch, patch};
low() = BooleanIntersection{ Volume{1}; }{ Volume{2}; };
high() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
ball() = BooleanFragments{ Volume{low()}; Delete; }{ Volume{high()}; Delete; };
under() = BooleanFragments{ Volume{3}; Delete; }{ Volume{4}; Delete; };

e = 1e-6;
Physical Volume("ball") = ball();
Physical Volume("plate") = under();
Physical Surface("cap") = {22};
Physical Surface("patch") = Surface In BoundingBox{-e, -e, -e, patch + e, patch + e, e};
Physical Surface("ball_x") = Surface In BoundingBox{-e, -e, -e, e, radius + e, 2 * radius + e};
Physical Surface("ball_y") = Surface In BoundingBox{-e, -e, -e, radius + e, e, 2 * radius + e};
Physical Surface("plate_x") = Surface In BoundingBox{-e, -e, -plate - e, e, plate + e, e};
Physical Surface("plate_y") = Surface In BoundingBox{-e, -e, -plate - e, plate + e, e, e};
Physical Surface("bottom") = Surface In BoundingBox{-e, -e, -plate - e, plate + e, plate + e, -plate + e};
Physical Surface("side_x") = Surface In BoundingBox{plate - e, -e, -plate - e, plate + e, plate + e, e};
Physical Surface("side_y") = Surface In BoundingBox{-e, plate - e, -plate - e, plate + e, plate + e, e};
Field[1] = MathEval;
Field[1].F = Sprintf("(1 + 0.05 * (1 - z / (Abs(z) + 1e-9))) * Min(%g, %g + %g * Max(Sqrt(x^2 + y^2 + z^2) - %g, 0))", coarse, fine, growth, touching);
Background Field = 1;
Mesh.Algorithm = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
