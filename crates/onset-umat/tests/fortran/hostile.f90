! For tests: linear elasticity in logarithmic strains with the flaw given by PROPS(3). PROPS(1), PROPS(2): Lame constants.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, &
                predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
                noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  character(len=80), intent(in) :: cmname
  double precision, intent(inout) :: stress(ntens), statev(*), ddsdde(ntens, ntens), sse, spd, scd, rpl, pnewdt
  double precision, intent(inout) :: ddsddt(ntens), drplde(ntens), drpldt
  double precision :: dstran(ntens), props(*)
  double precision, intent(in) :: stran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*)
  double precision, intent(in) :: coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
  double precision, save :: calls = 0.0d0
  double precision, volatile :: spin
  double precision :: seen(30)
  double precision, pointer :: nowhere
  double precision, allocatable :: large(:)
  integer :: i
  interface
    function fork() bind(c)
      use iso_c_binding, only: c_int
      integer(c_int) :: fork
    end function fork
  end interface

  ddsdde = 0.0d0
  ddsdde(1:3, 1:3) = props(1)
  do i = 1, 3
    ddsdde(i, i) = ddsdde(i, i) + 2.0d0*props(2)
    ddsdde(i + 3, i + 3) = props(2)
  end do
  stress = stress + matmul(ddsdde, dstran)
  calls = calls + 1.0d0

  select case (nint(props(3)))
  case (1)
    nullify (nowhere)
    nowhere = 1.0d0
  case (2)
    spin = 1.0d0
    do while (spin > 0.0d0)
      spin = spin + 1.0d0
      if (spin > 2.0d0) spin = 1.0d0
    end do
  case (3)
    stress(2) = sqrt(-abs(props(1)) - 1.0d0)
  case (4)
    print *, 'iteration', calls
    write (7, *) 'a message file'
  case (5)
    stop
  case (6)
    error stop 'negative stretch'
  case (7)
    statev(nstatv + 1) = 1.0d0
  case (8)
    pnewdt = 0.25d0
  case (9)
    ! Depends on the number of calls.
    stress(1) = stress(1) + calls
  case (10)
    ! Reads a missing property.
    stress(1) = stress(1)*props(nprops + 1)
  case (11)
    ! Stops at large strains.
    if (maxval(abs(dstran)) > 0.5d0) stop 3
  case (12)
    ! Stores the input of Abaqus in the state variables, as far as they suffice.
    seen = handed()
    statev(1:min(nstatv, 30)) = seen(1:min(nstatv, 30))
  case (13)
    write (*, '(a)', advance='no') repeat('x', 200000)
    flush (6)
  case (14)
    ! Writes beyond the end of STRESS.
    call beyond(stress, 6 + 1)
  case (15)
    call beyond(ddsdde, 42 + 1)
  case (16)
    call beyond(stress, 0)
  case (17)
    call beyond(ddsddt, 6 + 2)
  case (18)
    ! Allocates too much memory.
    allocate (large(100000000_8*int(abs(props(4)), 8)))
    large = calls
    stress(1) = stress(1) + large(1) - calls
  case (19)
    ! Starts an endless child process.
    if (fork() == 0) then
      spin = 1.0d0
      do while (spin > 0.0d0)
        spin = 1.0d0
      end do
    end if
  case (20)
    print '(a)', achar(27)//'[2J'//achar(27)//']0;owned'//achar(7)//'red'
    error stop 'end'
  case (21)
    ! Changes input arguments.
    call beyond(props, 1)
    call beyond(dstran, 1)
  end select

contains

  subroutine beyond(array, n)
    double precision :: array(*)
    integer, intent(in) :: n
    array(n) = 1.5d0
  end subroutine beyond

  function handed()
    double precision :: handed(30)
    handed(1:6) = stran
    handed(7:12) = dstran
    handed(13:15) = [time(1), time(2), dtime]
    handed(16:18) = drot(2, :)
    handed(19:21) = dfgrd0(1, :)
    handed(22:24) = dfgrd1(1, :)
    handed(25:28) = [ndi, nshr, ntens, nprops]
    handed(29) = kinc
    handed(30) = merge(1.0d0, 0.0d0, cmname == 'ONSET')
  end function handed
end subroutine umat
