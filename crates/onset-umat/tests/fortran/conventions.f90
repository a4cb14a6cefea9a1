! For tests: the Blatz-Ko law with a tangent in the convention given by PROPS(2). All tangents are computed by complex-step
! differentiation, independently of the formulas that relate them. PROPS(1) = mu. PROPS(2):
!   0 Jaumann rate of Kirchhoff stress over J     1 Jaumann rate of Cauchy stress     2 Truesdell
!   3 Green-Naghdi rate of Cauchy stress          4 Green-Naghdi rate of Kirchhoff stress over J
!   5 dS/dE     6 Cauchy stress per sym(F)        7 Cauchy stress per logarithmic strain, rotation held
!   8 dP/dF     9 dN/dF, N = P^T                 10 elasticity of the reference configuration
! PROPS(3), a sum of: 1 transposed, 2 tensor shear strains, 4 factor J missing (too large by J), 8 order 11 22 33 23 13 12, 16 SSE per reference volume.
module onset_conventions
  implicit none
  integer, parameter :: dp = kind(1.0d0)
  integer, parameter :: first(6) = [1, 2, 3, 1, 1, 2], second(6) = [1, 2, 3, 2, 3, 3]
  complex(dp), parameter :: one(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])

contains

  function inverse(f) result(g)
    complex(dp), intent(in) :: f(3, 3)
    complex(dp) :: g(3, 3)
    integer :: r, c, r1, r2, c1, c2
    do c = 1, 3
      do r = 1, 3
        r1 = mod(r, 3) + 1
        r2 = mod(r1, 3) + 1
        c1 = mod(c, 3) + 1
        c2 = mod(c1, 3) + 1
        g(r, c) = f(c1, r1)*f(c2, r2) - f(c1, r2)*f(c2, r1)
      end do
    end do
    g = g/determinant(f)
  end function inverse

  function determinant(f) result(d)
    complex(dp), intent(in) :: f(3, 3)
    complex(dp) :: d
    d = f(1, 1)*(f(2, 2)*f(3, 3) - f(2, 3)*f(3, 2)) - f(1, 2)*(f(2, 1)*f(3, 3) - f(2, 3)*f(3, 1)) &
        + f(1, 3)*(f(2, 1)*f(3, 2) - f(2, 2)*f(3, 1))
  end function determinant

  function cauchy(mu, f) result(sigma)
    real(dp), intent(in) :: mu
    complex(dp), intent(in) :: f(3, 3)
    complex(dp) :: sigma(3, 3), g(3, 3)
    g = inverse(f)
    sigma = mu*(one - matmul(transpose(g), g)/determinant(f))
  end function cauchy

  ! Rotation of F by Newton's iteration R <- (R + R^-T)/2, which can be differentiated by the complex step.
  function rotation(f) result(r)
    complex(dp), intent(in) :: f(3, 3)
    complex(dp) :: r(3, 3)
    integer :: n
    r = f
    do n = 1, 60
      r = 0.5_dp*(r + transpose(inverse(r)))
    end do
  end function rotation

  ! The exponential of a matrix near zero, as a power series.
  function exponential(h) result(e)
    complex(dp), intent(in) :: h(3, 3)
    complex(dp) :: e(3, 3), term(3, 3)
    integer :: n
    e = one
    term = one
    do n = 1, 40
      term = matmul(term, h)/n
      e = e + term
    end do
  end function exponential

  ! The logarithm of a matrix near one, as ln V = 2 artanh((V - 1)(V + 1)^-1).
  function logarithm(v) result(h)
    complex(dp), intent(in) :: v(3, 3)
    complex(dp) :: h(3, 3), z(3, 3), term(3, 3)
    integer :: n
    z = matmul(v - one, inverse(v + one))
    term = z
    h = 0.0_dp
    do n = 1, 200, 2
      h = h + 2.0_dp*term/n
      term = matmul(term, matmul(z, z))
    end do
  end function logarithm
end module onset_conventions

subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, &
                predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
                noel, npt, layer, kspt, jstep, kinc)
  use onset_conventions
  implicit none
  integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  character(len=80), intent(in) :: cmname
  double precision, intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, pnewdt
  double precision, intent(inout) :: ddsddt(ntens), drplde(ntens), drpldt
  double precision, intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*)
  double precision, intent(in) :: props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
  integer, parameter :: standard(6) = [1, 2, 3, 6, 5, 4]
  real(dp), parameter :: small = 1.0e-30_dp
  complex(dp) :: f(3, 3), moved(3, 3), unit(3, 3), result(3, 3), r(3, 3), h(3, 3), g(3, 3)
  real(dp) :: mu, jacobian, change(3, 3)
  integer :: q, k, l, p, change_kind, flaws

  mu = props(1)
  change_kind = nint(props(2))
  flaws = nint(props(3))
  f = dfgrd1
  if (change_kind == 10) f = one
  jacobian = real(determinant(f), dp)
  r = rotation(f)
  h = logarithm(matmul(f, transpose(r)))
  do q = 1, 6
    k = first(q)
    l = second(q)
    unit = 0.0_dp
    unit(k, l) = unit(k, l) + 0.5_dp
    unit(l, k) = unit(l, k) + 0.5_dp
    unit = cmplx(0.0_dp, small, dp)*unit
    select case (change_kind)
    case (5)
      ! dE = sym(F^T dF) is the unit for dF = F^-T dE.
      moved = f + matmul(transpose(inverse(f)), unit)
    case (6)
      moved = f + unit
    case (7)
      moved = matmul(exponential(h + unit), r)
    case (8, 9)
      moved = f
      moved(k, l) = moved(k, l) + cmplx(0.0_dp, small, dp)
      if (change_kind == 9) then
        moved = f
        moved(l, k) = moved(l, k) + cmplx(0.0_dp, small, dp)
      end if
    case default
      moved = matmul(one + unit, f)
    end select
    result = cauchy(mu, moved)
    g = inverse(moved)
    select case (change_kind)
    case (0, 10)
      result = determinant(moved)*result/jacobian
    case (2, 5)
      result = determinant(moved)*matmul(g, matmul(result, transpose(g)))
    case (3)
      result = matmul(transpose(rotation(moved)), matmul(result, rotation(moved)))
    case (4)
      result = determinant(moved)*matmul(transpose(rotation(moved)), matmul(result, rotation(moved)))/jacobian
    case (8)
      result = determinant(moved)*matmul(result, transpose(g))
    case (9)
      result = determinant(moved)*matmul(g, result)
    end select
    change = aimag(result)/small
    select case (change_kind)
    case (2)
      change = real(matmul(f, matmul(change, transpose(f))), dp)/jacobian
    case (3, 4)
      change = real(matmul(r, matmul(change, transpose(r))), dp)
    end select
    do p = 1, 6
      ddsdde(p, q) = change(first(p), second(p))
    end do
  end do

  if (iand(flaws, 1) /= 0) ddsdde = transpose(ddsdde)
  if (iand(flaws, 2) /= 0) ddsdde(:, 4:6) = 2.0_dp*ddsdde(:, 4:6)
  if (iand(flaws, 4) /= 0) ddsdde = jacobian*ddsdde
  if (iand(flaws, 8) /= 0) ddsdde = ddsdde(standard, standard)

  f = dfgrd1
  result = cauchy(mu, f)
  do p = 1, 6
    stress(p) = real(result(first(p), second(p)), dp)
  end do
  g = inverse(f)
  sse = 0.5_dp*mu*real((sum(g**2) + 2.0_dp*determinant(f) - 5.0_dp)/determinant(f), dp)
  if (iand(flaws, 16) /= 0) sse = sse*real(determinant(f), dp)
end subroutine umat
