! The law of Blatz and Ko for a foamed rubber as an Abaqus UMAT:
!
!   W = mu/2 (I2/J^2 + 2 J - 5),   sigma = mu (1 - B^-1 / J),   B = F F^T
!
! PROPS(1) = mu, in units of stress. No state variables. SSE is W/J, per current volume as in Abaqus.
!
! With b = B^-1 and no spin, B' = D B + B D, so that b' = -(b D + D b) and the Jaumann rate of J sigma = mu (J 1 - b) is
! mu (b D + D b + J tr(D) 1). DDSDDE is that over J.
!
!   gfortran -shared -fPIC -O2 -o blatz_ko.so blatz_ko.f90
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, &
                predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
                noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  character(len=80), intent(in) :: cmname
  double precision, intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, pnewdt
  double precision, intent(inout) :: ddsddt(ntens), drplde(ntens), drpldt
  double precision, intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*)
  double precision, intent(in) :: props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
  integer, parameter :: first(6) = [1, 2, 3, 1, 1, 2], second(6) = [1, 2, 3, 2, 3, 3]
  double precision :: mu, jacobian, inverse(3, 3), b(3, 3), tangent
  integer :: p, q, i, j, k, l

  mu = props(1)
  call invert(dfgrd1, inverse, jacobian)
  b = matmul(transpose(inverse), inverse)
  do p = 1, ntens
    i = first(p)
    j = second(p)
    stress(p) = mu*(delta(i, j) - b(i, j)/jacobian)
    do q = 1, ntens
      k = first(q)
      l = second(q)
      tangent = delta(i, k)*b(l, j) + delta(i, l)*b(k, j) + b(i, k)*delta(l, j) + b(i, l)*delta(k, j)
      ddsdde(p, q) = mu*(0.5d0*tangent/jacobian + delta(i, j)*delta(k, l))
    end do
  end do
  sse = 0.5d0*mu*(b(1, 1) + b(2, 2) + b(3, 3) + 2.0d0*jacobian - 5.0d0)/jacobian

contains

  pure double precision function delta(row, column)
    integer, intent(in) :: row, column
    delta = merge(1.0d0, 0.0d0, row == column)
  end function delta

  pure subroutine invert(f, g, determinant)
    double precision, intent(in) :: f(3, 3)
    double precision, intent(out) :: g(3, 3), determinant
    integer :: r, c
    do c = 1, 3
      do r = 1, 3
        ! The cofactor of the entry (c, r).
        g(r, c) = f(next(c), next(r))*f(next(next(c)), next(next(r))) - f(next(c), next(next(r)))*f(next(next(c)), next(r))
      end do
    end do
    determinant = f(1, 1)*g(1, 1) + f(1, 2)*g(2, 1) + f(1, 3)*g(3, 1)
    g = g/determinant
  end subroutine invert

  pure integer function next(index)
    integer, intent(in) :: index
    next = mod(index, 3) + 1
  end function next
end subroutine umat
