! explicit_bar --name NAME --connect ENDPOINT ...: explicit participant with its own time loop, the far three quarters of
! the left bar of configs/two_bars.toml, x = -0.254 m to -0.0635 m. Central differences with two-node bars:
!   u = u + dt v + dt^2/2 a,   a = -M^-1 K u (+ lambda / m at the shared node),   P = K u at the shared node
! Driven by displacement the shared node's u is the link's; driven by force it is a node like the others, and lambda is
! linear over the steps of a window.
program explicit_bar
  use, intrinsic :: iso_c_binding
  use ricochet
  implicit none
  integer, parameter :: n = 15
  real(c_double), parameter :: length = 0.1905d0, h = length / n, k = 206.8d9 * 6.4516d-4 / h, &
                               m = 7844.066d0 * 6.4516d-4 * h
  type :: bar
    real(c_double), dimension(0:n) :: u = 0, v = 5.13588d0, a = 0, internal = 0
    real(c_double) :: link = 0, work = 0
  end type
  type(bar) :: now, saved
  type(c_ptr) :: loop
  real(c_double) :: mass(0:n), link(1)
  logical :: by_force
  integer :: i

  mass = m
  mass(0) = m / 2
  mass(n) = m / 2
  loop = ricochet_open("explicit" // c_null_char, "explicit_bar.f90" // c_null_char, 1_c_int)
  if (.not. c_associated(loop)) call exit(2)
  call check(ricochet_add_body(loop, "left" // c_null_char))
  call check(ricochet_set_interface(loop, 1_c_int, [0_c_int], [-0.0635d0], [mass(n)]))
  call check(ricochet_set_critical_time_step(loop, sqrt(m / k)))
  call check(ricochet_add_capability(loop, "repeat_window" // c_null_char))
  call check(ricochet_add_capability(loop, "driven_by_force" // c_null_char))
  call check(ricochet_add_capability(loop, "reconfigure" // c_null_char))
  call check(ricochet_add_column(loop, "mass_kg/left" // c_null_char))
  call check(ricochet_add_column(loop, "energy_kinetic_j/left" // c_null_char))
  call check(ricochet_add_column(loop, "energy_strain_j/left" // c_null_char))
  call check(ricochet_add_column(loop, "energy_interface_j/left" // c_null_char))
  call check(ricochet_add_column(loop, "momentum_n_kg_m_s/left" // c_null_char))

  call check(ricochet_initialize(loop, [0d0], [(0d0, i = 1, 5)]))
  by_force = ricochet_driven_by_force(loop) == 1
  if (.not. by_force) now%v(n) = 0  ! the link moves that node
  do while (ricochet_ongoing(loop) == 1)
    if (ricochet_must_save(loop) == 1) saved = now
    call check(ricochet_read(loop, link))
    call window(now, ricochet_max_time_step(loop), link(1))
    if (by_force) then
      call check(ricochet_write(loop, now%u(n:), now%v(n:), now%a(n:), record=record(now)))
    else
      call check(ricochet_write(loop, now%internal(n:), record=record(now)))
    end if
    call check(ricochet_advance(loop))
    if (ricochet_must_restore(loop) == 1) now = saved
  end do
  call exit(ricochet_close(loop))

contains

  subroutine check(error)
    integer(c_int), intent(in) :: error
    if (error /= 0) call exit(error)  ! what is wrong stands on standard error already
  end subroutine

  subroutine window(s, size, link_end)
    type(bar), intent(inout) :: s
    real(c_double), intent(in) :: size, link_end
    real(c_double) :: dt, from, to, u_old, p_old
    integer :: j, steps
    steps = ricochet_substeps(loop)
    dt = size / steps
    to = s%link
    do j = 1, steps
      from = to
      to = s%link + real(j, c_double) / steps * (link_end - s%link)
      u_old = s%u(n)
      p_old = s%internal(n)
      s%u = s%u + dt * s%v + 0.5d0 * dt**2 * s%a
      s%v = s%v + 0.5d0 * dt * s%a
      if (.not. by_force) s%u(n) = link_end
      s%internal = 0
      s%internal(:n-1) = k * (s%u(:n-1) - s%u(1:))
      s%internal(1:) = s%internal(1:) - k * (s%u(:n-1) - s%u(1:))
      s%a = -s%internal / mass
      if (by_force) then
        s%a(n) = s%a(n) + to / mass(n)
        s%work = s%work + 0.5d0 * (from + to) * (s%u(n) - u_old)
      else
        s%a(n) = 0
        s%work = s%work + 0.5d0 * (p_old + s%internal(n)) * (s%u(n) - u_old)
      end if
      s%v = s%v + 0.5d0 * dt * s%a
    end do
    s%link = link_end
  end subroutine

  function record(s) result(row)
    type(bar), intent(in) :: s
    real(c_double) :: row(5), dt
    integer :: last  ! of the nodes that it integrates
    last = merge(n, n - 1, by_force)
    dt = ricochet_window_size(loop) / ricochet_substeps(loop)
    row = [sum(mass(:last)), 0.5d0 * sum(mass(:last) * (s%v(:last)**2 - (0.5d0 * dt * s%a(:last))**2)), &
           0.5d0 * sum(s%u * s%internal), s%work, sum(mass(:last) * s%v(:last))]
  end function
end program explicit_bar
