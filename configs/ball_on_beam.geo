// A quarter of a steel ball of radius 70 mm that touches, from above, a quarter of a beam of 60 x 780 x 27.8 mm at the origin [m]: x = 0 and y = 0 are
// planes of symmetry.
//   gmsh -3 -format msh41 ball_on_beam.geo -o ball_on_beam.msh
// Tetrahedra with edges of 1 mm out to `touching`, farther away growing by `growth` per length up to 7 mm; `-setnumber refinement 2` halves every
// edge.
// The groups "ball_near" and "beam_near" hold the elements within `near` of the origin; the surfaces "cap" and "top", within `tip`, may touch.
SetFactory("OpenCASCADE");
DefineConstant[ refinement = 1 ];
radius = 0.070; width = 0.030; length = 0.390; depth = 0.0278; tip = 0.008; near = 0.012;
touching = 0.004; growth = 0.5;
fine = 1e-3 / refinement; coarse = 7e-3 / refinement;

Sphere(1) = {0, 0, radius, radius, -Pi / 2, Pi / 2, Pi / 2};
Box(2) = {0, 0, -depth, width, length, depth};
// Shells of each around the origin: out to `tip`, to `near`, and the rest.
For body In {1 : 2}
  Sphere(10 * body + 1) = {0, 0, 0, tip, -Pi / 2, Pi / 2, Pi / 2};
  Sphere(10 * body + 2) = {0, 0, 0, near, -Pi / 2, Pi / 2, Pi / 2};
  inner() = BooleanIntersection{ Volume{body}; }{ Volume{10 * body + 1}; };
  middle() = BooleanIntersection{ Volume{body}; }{ Volume{10 * body + 2}; Delete; };
  BooleanFragments{ Volume{body}; Delete; }{ Volume{inner(), middle()}; Delete; }
  Recursive Delete { Volume{10 * body + 1}; }
EndFor

Physical Volume("ball") = {13, 14, 15};
Physical Volume("ball_near") = {13, 15};
Physical Volume("beam") = {23, 24, 25};
Physical Volume("beam_near") = {23, 25};
Physical Surface("cap") = {16};
Physical Surface("ball_x") = {17, 21, 25};
Physical Surface("ball_y") = {18, 23, 26};
Physical Surface("top") = {35};
Physical Surface("beam_x") = {33, 37, 44};
Physical Surface("beam_y") = {34, 38, 45};
Physical Surface("end") = {41};

Field[1] = MathEval;
Field[1].F = Sprintf("Min(%g, %g + %g * Max(Sqrt(x^2 + y^2 + z^2) - %g, 0))", coarse, fine, growth, touching);
Background Field = 1;
Mesh.Algorithm = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
