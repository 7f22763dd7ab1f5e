// Half of a ball of radius 2.5 mm, y >= 0, above half of a block of glass, 24 mm wide and 12 mm deep; they touch at the origin [m].
//   gmsh -3 -format msh41 alumina_ball.geo -o alumina_ball.msh
// Tetrahedra with edges of 0.05 mm out to `touching`, farther away growing by `growth` per length up to 0.4 mm (ball)
// and 2.4 mm (glass), whose edges are a tenth longer. `-setnumber refinement 2` halves every edge.
SetFactory("OpenCASCADE");
DefineConstant[ refinement = 1 ];
radius = 0.0025; cap = radius * (1 - Cos(0.3)); block = 0.012; patch = 0.0008; touching = 0.28e-3; growth = 0.3;
fine = 0.05e-3 / refinement;

Sphere(1) = {0, 0, radius, radius, -Pi / 2, Pi / 2, Pi};
Box(2) = {-radius, 0, 0, 2 * radius, radius, cap};
Box(3) = {-block, 0, -block, 2 * block, block, block};
Box(4) = {-patch, 0, -patch, 2 * patch, patch, patch};
low() = BooleanIntersection{ Volume{1}; }{ Volume{2}; };
high() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
ball() = BooleanFragments{ Volume{low()}; Delete; }{ Volume{high()}; Delete; };
under() = BooleanFragments{ Volume{3}; Delete; }{ Volume{4}; Delete; };

e = 1e-6;
Physical Volume("ball") = ball();
Physical Volume("anvil") = under();
Physical Surface("patch") = Surface In BoundingBox{-patch - e, -e, -e, patch + e, patch + e, e};
Physical Surface("ball_middle") = Surface In BoundingBox{-radius - e, -e, -e, radius + e, e, 2 * radius + e};
Physical Surface("anvil_middle") = Surface In BoundingBox{-block - e, -e, -block - e, block + e, e, e};
Physical Surface("cap") = {22};
Physical Surface("bottom") = Surface In BoundingBox{-block - e, -e, -block - e, block + e, block + e, -block + e};
Physical Surface("back") = Surface In BoundingBox{-block - e, block - e, -block - e, block + e, block + e, e};
Physical Surface("left") = Surface In BoundingBox{-block - e, -e, -block - e, -block + e, block + e, e};
Physical Surface("right") = Surface In BoundingBox{block - e, -e, -block - e, block + e, block + e, e};
Field[1] = MathEval;
Field[1].F = Sprintf("(1 + 0.05 * (1 - z / (Abs(z) + 1e-9))) * Min(%g * (1 + 2.5 * (1 - z / (Abs(z) + 1e-9))), %g + %g * Max(Sqrt(x^2 + y^2 + z^2) - %g, 0))", 0.4e-3 / refinement, fine, growth, touching);
Background Field = 1;
Mesh.Algorithm = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
