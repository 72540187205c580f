!> Tests of the scene reader: what is read, what is the default, what is refused and where.
!>
!> In the texts of these tests a `|` stands for a line end.
module asperity_scene_suite
  use asperity_byte_reader, only: byte_reader
  use asperity_coupled_scenes, only: random
  use asperity_decimal, only: decimal_numeral, decimal_to_real64, decimal_value
  use asperity_kinds, only: int64, real128, real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: problem_list
  use asperity_scene_reader, only: parse_scene
  use asperity_scene_values, only: effect_off, scene
  use asperity_surface_csv, only: parse_surface_csv, surface_table
  use asperity_testing, only: check, has_failed, run_test
  implicit none
  private

  public :: run_scene

  ! Texts are read as if they stood here; tests run in the project's folder.
  character(len=*), parameter :: place = 'data/examples/t.scene'
  character(len=*), parameter :: deck = '&surfaces deck = "../thesis.deck" / '
  character(len=*), parameter :: files = '&surfaces upper="ball.csv", lower="bump.csv" / '
  character(len=*), parameter :: material = &
    '&material elastic_modulus=2*1, poisson_ratio=2*0 / '
  character(len=*), parameter :: limit = '&limit value=1 / '

contains

  !> Runs the tests.
  subroutine run_scene
    call run_test('numbers are read exactly', test_numerals)
    call run_test('what is no number is refused', test_bad_numerals)
    call run_test('quick conversion equals the library''s', test_decimal_to_real64)
    call run_test('a group overrides the deck name by name', test_overrides)
    call run_test('syntax that is accepted', test_syntax)
    call run_test('radii from the files', test_csv_radii)
    call run_test('bad syntax', test_bad_syntax)
    call run_test('unknown and repeated groups and names', test_unknown)
    call run_test('bad values', test_bad_values)
    call run_test('names missing or out of place', test_missing)
    call run_test('all problems of all files are shown', test_all_problems)
    call run_test('a file that changes while it is read', test_changing_file)
    call run_test('true and false', test_true_and_false)
    call run_test('long surface files', test_long_csv)
    call run_test('bad surface files', test_bad_csv)
    call run_test('many problems are counted', test_many_problems)
  end subroutine run_scene

  subroutine test_numerals
    call one('2', 2_int64, 0)
    call one('-.5', -5_int64, -1)
    call one('+1.', 1_int64, 0)
    call one('1.270', 1270_int64, -3)
    call one('4d5', 4_int64, 5)
    call one('4.25E-07', 425_int64, -9)
    call one('0.000', 0_int64, 0)
    call one('000012345678901234567.8', 123456789012345678_int64, -1)
    call one('12345678901234567849.9', 123456789012345678_int64, 2)
    call one('1234567890123456785', 123456789012345679_int64, 1)
    call one('0.1234567890123456784999', 123456789012345678_int64, -18)
    call one('999999999999999999.9', 1000000000000000000_int64, 0)

  contains

    subroutine one(token, digits, exponent)
      character(len=*), intent(in) :: token
      integer(int64), intent(in) :: digits
      integer, intent(in) :: exponent
      type(decimal_value) :: value
      logical :: good

      call read_numeral(token, value, good)
      call check(good, token // ' was refused')
      call check(value%all_digits, digits, 'digits of ' // token)
      call check(value%power_of_ten, exponent, 'exponent of ' // token)
    end subroutine one

  end subroutine test_numerals

  subroutine test_bad_numerals
    character(len=13), parameter :: bad(*) = [character(len=13) :: '', '-', '.', '+.', '1e', &
      '1e+', '1.2.3', '1-5', '--1', 'e5', '1e5.', '0x10', 'nan', 'inf', '-Infinity', '1e309', &
      '-1.8e308', '1e-400', '1e99999999999', '1e-9999999', '1,5', '1 2', '1_8', '1e1e1']
    type(decimal_value) :: value
    logical :: good
    integer :: i

    do i = 1, size(bad)
      call read_numeral(trim(bad(i)), value, good)
      call check(.not. good, '"' // trim(bad(i)) // '" was taken for a number')
    end do
  end subroutine test_bad_numerals

  !> What was cut or has grown since it was opened is not taken for the whole file.
  subroutine test_changing_file
    character(len=*), parameter :: path = 'build/changing.txt'
    character(len=:), allocatable :: text
    type(byte_reader) :: file
    integer :: change

    do change = -1, 1
      call write_lines(20000)
      call file%open(path)
      call write_lines(20000 + 10000 * change)
      call file%take_whole(text)
      call file%close()
      if (change == 0) then
        call check(.not. allocated(file%failure), 'a file was refused')
        call check(len(text), 200000, 'length of a file')
      else
        call check(allocated(file%failure), 'a part of a file was taken for the whole')
      end if
    end do

  contains

    subroutine write_lines(number)
      integer, intent(in) :: number
      integer :: unit

      open (newunit=unit, file=path, status='replace', action='write', access='stream')
      write (unit) repeat('123456789' // new_line('a'), number)
      close (unit)
    end subroutine write_lines

  end subroutine test_changing_file

  !> They stand for on and off, and for nothing else.
  subroutine test_true_and_false
    character(len=*), parameter :: rest = ', plastic_yield_stress = 1. /'
    character(len=7), parameter :: words(4) = [character(len=7) :: '.true.', 'True', '.FALSE.', &
                                               'false']
    type(scene) :: found
    type(problem_list) :: problems
    integer :: i

    do i = 1, size(words)
      call parse_scene(place, deck // '&effects plasticity = ' // trim(words(i)) // rest, found, &
                       problems)
      call check(problems%text(), '', trim(words(i)))
      call check((found%effects%mode('plasticity') /= effect_off) .eqv. i < 3, words(i))
    end do
    call parse_scene(place, deck // '&effects tolerance = True /', found, problems)
    call check(problems%text(), place // ':1:58: tolerance: found ''True'', expected a ' // &
               'number more than 0 and less than 1' // new_line('a'), 'a number')
  end subroutine test_true_and_false

  !> Digits of all lengths, all exponents on either side of the quick range, and what is nearest to
  !> the middle of two doubles, as the library reads them: it rounds correctly.
  subroutine test_decimal_to_real64
    integer(int64) :: state
    real(real64) :: unused
    integer :: i, exponent

    state = 88172645463325252_int64
    do i = 1, 2000
      do exponent = -30, 26, 7
        unused = random(state)
        call one(decimal_value(mod(state, 10_int64**(1 + mod(i, 18))), exponent + mod(i, 7)))
      end do
      unused = random(state)
      call one(middle(scale(real(state, real64), -63 - mod(i, 40))))
      ! Exactly in the middle: above 2**53 every other whole number is.
      state = 2_int64**53 + 2_int64 * mod(state, 2_int64**40) + 1_int64
      call one(decimal_value(state, 0))
      call one(decimal_value(10_int64 * state, -1))
    end do

  contains

    !> The middle of a double below 1 and the next one, to 18 digits.
    function middle(x) result(value)
      real(real64), intent(in) :: x
      type(decimal_value) :: value
      character(len=32) :: text
      logical :: good

      write (text, '(es32.17e3)') real(x, real128) + real(spacing(x), real128) / 2
      call read_numeral(trim(adjustl(text)), value, good)
    end function middle

    subroutine one(value)
      type(decimal_value), intent(in) :: value
      real(real64) :: expected
      character(len=40) :: numeral

      numeral = decimal_numeral(value)
      read (numeral, '(f40.0)') expected
      call check(transfer(decimal_to_real64(value), 0_int64), transfer(expected, 0_int64), &
                 'bits of ' // trim(adjustl(numeral)))
    end subroutine one

  end subroutine test_decimal_to_real64

  subroutine test_overrides
    type(scene) :: found

    call accept(deck // '&material poisson_ratio = 0.3, 0.25 / &tilt rotation = 1, 2 /' // &
                '&limit value = 100 / &motion positions = 3, y_step = -.5/', found)
    if (has_failed()) return
    call check_number(found%upper%elastic_modulus, 275760.0_real64, 'modulus')
    call check_number(found%upper%poisson_ratio, 0.3_real64, 'upper ratio')
    call check_number(found%lower%poisson_ratio, 0.25_real64, 'lower ratio')
    call check_number(found%upper%slope(1), 0.004_real64, 'slope')
    call check_number(found%upper%rotation, 1.0_real64, 'upper rotation')
    call check_number(found%lower%rotation, 2.0_real64, 'lower rotation')
    call check_number(found%limit%value, 100.0_real64, 'limit load')
    call check(.not. found%limit%from_thesis, 'the limit is the scene''s')
    call check(found%motion%positions, 3, 'positions')
    call check_number(found%motion%y_step, -0.5_real64, 'y step')
    call check_number(found%motion%x_first, 0.0_real64, 'first x')
  end subroutine test_overrides

  subroutine test_syntax
    type(scene) :: found
    character(len=*), parameter :: crlf = achar(13) // '|'

    call accept('! a comment with / and & and ''|| &SURFACES Deck=''../thesis.deck''/' // &
                '&Tilt upper_SLOPE=2*-1d-3 ! comment|lower_slope = 1 2|, rotation=.5,' // &
                crlf // '2.e0,/!end' // crlf // '&loading CONTROL="Approach" value=-3E-1/|', found)
    if (has_failed()) return
    call check_number(found%upper%slope(1), -0.001_real64, 'upper slope x')
    call check_number(found%upper%slope(2), -0.001_real64, 'upper slope y')
    call check_number(found%lower%slope(1), 1.0_real64, 'lower slope x')
    call check_number(found%lower%slope(2), 2.0_real64, 'lower slope y')
    call check_number(found%upper%rotation, 0.5_real64, 'upper rotation')
    call check_number(found%lower%rotation, 2.0_real64, 'lower rotation')
    call check(trim(found%loading%control%word), 'separation', 'control')
    call check_number(found%loading%value, -0.3_real64, 'approach')
    call accept(char(239) // char(187) // char(191) // deck, found)
    ! A doubled quote is one, and the other kind of quote is a character.
    call refuse_file('&surfaces deck=''it''''s "x".deck'' /', &
                     'data/examples/it''s "x".deck:1:1: cannot be opened')
    call refuse_file('&surfaces deck="it''s ""x"".deck" /', &
                     'data/examples/it''s "x".deck:1:1: cannot be opened')
    call refuse_file('&surfaces deck="/none/x.deck" /', '/none/x.deck:1:1: cannot be opened')
  end subroutine test_syntax

  subroutine test_csv_radii
    type(scene) :: found

    ! A radius for the file that has none; the other keeps its own.
    call accept('&surfaces upper="ball.csv", lower="lower.csv", radius=9,7 /' // &
                material // limit, found)
    if (has_failed()) return
    call check_number(found%upper%radius(1), 5.0_real64, 'the file''s own radius')
    call check_number(found%lower%radius(5), 7.0_real64, 'the scene''s radius')
    call refuse('&surfaces upper="upper.csv", lower="bump.csv" /' // material // limit, &
                '1:1', 'no radius column in the upper surface''s file')
    call refuse('&surfaces upper="upper.csv", lower="lower.csv" /' // material // limit, &
                '1:1', 'no radius column in the upper and the lower surface''s file')
    call refuse('&surfaces upper="ball.csv", lower="bump.csv",| radius=1,1 /' // &
                material // limit, '2:2', 'radius: found although both surfaces')
  end subroutine test_csv_radii

  subroutine test_bad_syntax
    call refuse('', '1:1', 'found no group &surfaces')
    call refuse(deck // '| stray words /|', '2:2', 'text outside a group: found ''stray''')
    call refuse(deck // '|  &tilt rotation = 1, 1 |', '2:3', 'group ''&tilt'' has no end')
    call refuse(deck // '&tilt rotation = 1, 1 |  &loading points = 1 /', '2:3', &
                'group ''&tilt'' has no end')
    call refuse(deck // '|&loading control = ''limit /|', '2:20', 'a text has no end')
    call refuse_file(deck // '|&loading control = ''limit|'' /', &
                     place // ':2:20: a text has no end')
    call refuse(deck // '|& tilt rotation = 1, 1 /', '2:1', 'a group without a name')
    call refuse(deck // '|&tilt rotation(1) = 1 /', '2:15', 'an index is not read')
    call refuse(deck // '|&tilt = 1 /', '2:7', 'no name with values: found ''=''')
    call refuse(deck // '|&tilt rotation 1, 1 /', '2:7', 'no name with values')
    call refuse(deck // '|&tilt rotation = /', '2:18', 'a value is missing')
    call refuse(deck // '|&tilt rotation = 1,, 2 /', '2:20', 'a value is missing')
    call refuse(deck // '|&tilt rotation = , 1, 2 /', '2:18', 'a value is missing')
    call refuse(deck // '|&tilt rotation = 2* /', '2:20', 'a repeat count')
    call refuse(deck // '|&tilt rotation = 0*5 1 1/', '2:20', 'a repeat count')
    call refuse(deck // '|&tilt rotation = 9999999999*5/', '2:29', 'a repeat count')
    call refuse(deck // '|&tilt' // achar(0) // '/', '2:6', 'not a text file')
    call refuse(deck // '|&tilt rotation = 1, 2', '2:1', 'found the end of the file')
  end subroutine test_bad_syntax

  subroutine test_unknown
    call refuse(deck // '| &moton x_first = 1 /', '2:2', &
                'unknown group: found ''&moton'', expected &surfaces, &material, &motion, ' // &
                '&tilt, &loading, &limit or &effects')
    call refuse(deck // '|&motion|   X_frist = 1 /', '3:4', 'unknown name in &motion: ' // &
                'found ''x_frist'', expected x_first, x_step, y_first, y_step or positions')
    call refuse(deck // '|&motion / &motion /', '2:11', 'group &motion occurs twice')
    call refuse(deck // '|&motion x_first=1, x_first=1 /', '2:20', 'x_first occurs twice')
  end subroutine test_unknown

  subroutine test_bad_values
    character(len=*), parameter :: finite = 'expected a finite number within the range of a double'

    call refuse(deck // '|&motion x_first = 1.2.3 /', '2:19', 'found ''1.2.3'', ' // finite)
    call refuse(deck // '|&motion x_first = one /', '2:19', 'found ''one'', ' // finite)
    call refuse(deck // '|&motion x_first = "1" /', '2:19', 'found the text ''1'', ' // finite)
    call refuse(deck // '|&motion x_first = 1, 2 /', '2:9', 'found 2, expected 1')
    call refuse(deck // '|&tilt rotation = 1 /', '2:7', 'found 1, expected 2')
    call refuse(deck // '|&tilt rotation = 999999999*1 999999999*1 999999999*1 /', '2:7', &
                'found 2999999997, expected 2')
    call refuse(deck // '|&motion positions = 0 /', '2:21', 'a whole number from 1 to')
    call refuse(deck // '|&motion positions = 1.5 /', '2:21', 'a whole number from 1 to')
    call refuse(deck // '|&motion positions = 9999999999 /', '2:21', 'to 1000000')
    call refuse(deck // '|&motion x_step=1e308, positions=3 /', '2:1', 'the last position')
    call refuse(deck // '|&material elastic_modulus = 1, 0 /', '2:32', 'more than 0')
    call refuse(deck // '|&material poisson_ratio = 0.51, 0 /', '2:27', 'at most 0.5')
    call refuse(deck // '|&material poisson_ratio = 0, -1 /', '2:30', 'more than -1')
    call refuse(deck // '|&loading control="lode" /', '2:18', &
                'found the text ''lode'', expected ''limit'', ''separation'', ''load'', ' // &
                '''vertical_load'', ''pressure'', ''compression'', ''mean_gap'' or ''approach''')
    call refuse(deck // '|&loading control=limit /', '2:18', 'found ''limit'', expected')
    call refuse(deck // '|&loading control="load", value=0 /', '2:32', 'more than 0')
    call refuse(deck // '|&loading points=-1 /', '2:17', 'a whole number from 0')
    call refuse(deck // '|&limit criterion="luck", value=1 /', '2:18', &
                '''load'', ''pressure'', ''greenwood_williamson'' or ''hardy''')
    call refuse(deck // '|&limit value=-2 /', '2:14', 'more than 0')
    call refuse(deck // '|&effects tolerance=1 /', '2:20', 'less than 1')
    call refuse('&surfaces deck=5 /', '1:16', 'a text between quotes')
    call refuse('&surfaces deck="" /', '1:16', 'a text between quotes')
  end subroutine test_bad_values

  subroutine test_missing
    call refuse('&surfaces /', '1:1', 'a surface is missing')
    call refuse('&surfaces upper="ball.csv" /' // material // limit, '1:1', 'a surface is missing')
    call refuse('&surfaces upper="ball.csv", deck="../thesis.deck" /', '1:11', &
                'upper: found beside deck')
    call refuse(deck(:len(deck) - 2) // '|radius=1,1 /', '2:1', 'radius: found beside deck')
    call refuse(limit // files // '&material elastic_modulus=1,1 /', '1:65', &
                '&material needs poisson_ratio')
    call refuse(files // '|' // material, '1:1', &
                'no control and value in &loading; without them control is ''limit'', ' // &
                'which needs value in &limit')
    call refuse(files // '|' // material // '&limit /', '2:52', 'no control and value')
    call refuse(deck // '|&limit criterion="pressure" /', '2:1', &
                'criterion = ''pressure'' needs value in &limit')
    call refuse(deck // '|&limit criterion="hardy" /', '2:1', &
                'criterion = ''hardy'' needs yield_stress in &limit')
    call refuse(deck // '|&limit criterion="greenwood_williamson" /', '2:1', 'needs hardness')
    call refuse(deck // '|&limit criterion="hardy", yield_stress=1, value=2 /', '2:43', &
                'value: not used with criterion = ''hardy''')
    call refuse(deck // '|&limit hardness=2 /', '2:8', &
                'expected none, or criterion = ''greenwood_williamson''')
    call refuse(deck // '|&loading control="load" /', '2:1', &
                'control = ''load'' needs value in &loading')
    call refuse(deck // '|&loading value=3 /', '2:10', 'value: not used with control')
  end subroutine test_missing

  subroutine test_all_problems
    type(scene) :: found
    type(problem_list) :: problems

    call parse_scene(place, lines('&surfaces upper="none.csv", lower="bump.csv" /|' // &
                                  '&motion x_first=a, positions=b /|&limit|&tilt slope=1 /'), &
                     found, problems)
    call check(problems%text(), lines( &
         place // ':4:1: group ''&limit'' has no end: found another group, expected ''/''|' // &
         place // ':4:7: unknown name in &tilt: found ''slope'', ' // &
         'expected upper_slope, lower_slope or rotation|' // &
         place // ':1:1: &material needs elastic_modulus: found none, ' // &
         'expected one for upper and lower, or contact_modulus|' // &
         place // ':1:1: &material needs poisson_ratio: found none, ' // &
         'expected one for upper and lower, or contact_modulus|' // &
         place // ':2:17: x_first: found ''a'', ' // &
         'expected a finite number within the range of a double|' // &
         place // ':2:30: positions: found ''b'', ' // &
         'expected a whole number from 1 to 1000000|' // &
         place // ':3:1: no control and value in &loading; without them control is ''limit'', ' // &
         'which needs value in &limit: found none, expected one|' // &
         'data/examples/none.csv:1:1: cannot be opened: No such file or directory, ' // &
         'expected comma-separated numbers|'), 'all problems')
  end subroutine test_all_problems

  !> A long file: places of rows, and lines of problems, stay right to its end.
  subroutine test_long_csv
    integer, parameter :: count = 60000
    type(surface_table) :: table
    type(problem_list) :: problems
    character(len=24) :: row
    character(len=:), allocatable :: text, shown
    integer :: at, i, line

    allocate (character(len=32 * count) :: text)
    at = 0
    line = 1
    call put('x,y,height')
    do i = 1, count
      ! Lines that are no rows are thick in places: a piece may have few rows, or none.
      if (mod(i, 3) == 0 .or. (i > 20000 .and. i < 30000)) call put('')
      if (i == 40000) call put('# ' // repeat('long ', 60000))
      write (row, '(i0, ",", i0, ",-1.", i5.5)') i, -i, i
      call put(trim(row))
    end do
    call parse_copy(text(:at), table, problems)
    call check(problems%text(), '', 'problems')
    if (has_failed()) return
    call check(size(table%x), count, 'rows')
    if (has_failed()) return
    call check(all(nint(table%x) == [(i, i=1, count)]), 'x in order')
    call check(all(nint(table%y) == [(-i, i=1, count)]), 'y in order')
    call check(all(nint(-1.0e5_real64 * (table%height + 1.0_real64)) == &
                          [(i, i=1, count)]), 'heights in order')
    shown = ''
    do i = 1, 30
      write (row, '(i0)') line
      shown = shown // 's.csv:' // trim(row) // ':3: y: found ''b'', expected a finite number ' // &
             'within the range of a double' // new_line('a')
      if (i > 20) shown = shown(:index(shown(:len(shown) - 1), new_line('a'), back=.true.))
      call put('1,b,1')
    end do
    shown = shown // 's.csv: and 10 more like that' // new_line('a')
    call parse_copy(text(:at), table, problems)
    call check(problems%text(), shown, 'problems at the end')

  contains

    ! Adds a line.
    subroutine put(what)
      character(len=*), intent(in) :: what

      text(at + 1:at + len(what) + 1) = what // new_line('a')
      at = at + len(what) + 1
      line = line + 1
    end subroutine put

  end subroutine test_long_csv

  subroutine test_bad_csv
    character(len=*), parameter :: head = 'x,y,height,radius|'

    call one('', '1:1', 'the file is empty')
    call one(head, '2:1', 'no asperity')
    call one('x,y|1,2|', '1:1', 'no column height')
    call one('|x,y,height,raduis|1,2,3,4|', '2:12', 'unknown column: found ''raduis''')
    call one('x,y,X,height|', '1:5', 'column x occurs twice')
    call one('x,y,height,radius,|', '2:1', 'no asperity')
    call one('1,2,0.1,1|', '1:1', 'no header')
    call one(head // '1,2,0.1|', '2:1', 'found 3 cells, expected 4')
    call one(head // '1, b,0.1,1|', '2:4', 'y: found ''b'', expected a finite number')
    call one(head // '|1,2,nan,1|', '3:5', 'height: found ''nan''')
    call one(head // '1,2,0.1,1|1e999,2,0.1,1', '3:1', 'x: found ''1e999''')
    call one(head // '1,2,0.1,0|', '2:9', 'radius: found ''0'', expected more than 0')
    call one(head // '1,2,2.0,1|', '2:5', 'height: found ''2.0'', expected less than twice')
    call one(head // '"1",2,0.1,1|', '2:1', 'x: found ''"1"''')
    call one(head // '1,2' // achar(7) // ',0.1,1|', '2:4', 'not a text file')
    call one('x,y,height|1,2,2.5|', '2:5', 'less than twice the radius', radius=1.25_real64)

  contains

    subroutine one(text, where, fragment, radius)
      character(len=*), intent(in) :: text, where, fragment
      real(real64), intent(in), optional :: radius
      type(surface_table) :: table
      type(problem_list) :: problems

      call parse_copy(lines(text), table, problems, radius)
      call check(problems%count(), 1, 'problems of ' // text // ': ' // problems%text())
      call check_start(problems, 's.csv:' // where // ': ', fragment)
    end subroutine one

  end subroutine test_bad_csv

  ! Parses a copy of a surface's text.
  subroutine parse_copy(text, table, problems, radius)
    character(len=*), intent(in) :: text
    type(surface_table), intent(out) :: table
    type(problem_list), intent(out) :: problems
    real(real64), intent(in), optional :: radius  ! where no column gives radii; absent: none
    character(len=:), allocatable :: copy
    real(real64) :: common_radius

    common_radius = 0.0_real64
    if (present(radius)) common_radius = radius
    copy = text
    call parse_surface_csv('s.csv', copy, table, problems, common_radius)
  end subroutine parse_copy

  subroutine test_many_problems
    type(surface_table) :: table
    type(scene) :: found
    type(problem_list) :: problems
    character(len=:), allocatable :: text
    character(len=*), parameter :: csv_end = 's.csv: and 75 more problems' // new_line('a')
    character(len=*), parameter :: scene_end = place // ': and 4990 more like that' // new_line('a')

    call parse_copy(lines('x,y,height|' // repeat('a,1,1|1,a,1|', 2500) // &
                          repeat('a,1,1|1,1,a|1,1|', 25)), table, problems)
    text = problems%text()
    call check(problems%count(), 5075, 'problems')
    call check(number_of_lines(text), 5001, 'lines of problems')
    call check(index(text, csv_end) == len(text) - len(csv_end) + 1, 'the last line')
    call parse_scene(place, deck // '&tilt ' // repeat('a=1,', 5010) // '/', found, problems)
    text = problems%text()
    call check(problems%count(), 5010, 'problems of a scene')
    call check(number_of_lines(text), 21, 'lines of problems of a scene')
    call check(index(text, scene_end) == len(text) - len(scene_end) + 1, 'the scene''s last')
  end subroutine test_many_problems

  pure integer function number_of_lines(text)
    character(len=*), intent(in) :: text
    integer :: i

    number_of_lines = 0
    do i = 1, len(text)
      if (text(i:i) == new_line('a')) number_of_lines = number_of_lines + 1
    end do
  end function number_of_lines

  !> A text with `|` for line ends.
  pure function lines(text)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: lines
    integer :: i

    lines = text
    do i = 1, len(text)
      if (text(i:i) == '|') lines(i:i) = new_line('a')
    end do
  end function lines

  !> Reads a scene that must be good.
  subroutine accept(text, found)
    character(len=*), intent(in) :: text
    type(scene), intent(out) :: found
    type(problem_list) :: problems

    call parse_scene(place, lines(text), found, problems)
    call check(problems%text(), '', 'problems of ' // text)
  end subroutine accept

  !> Reads a scene that must have one problem, at a line and column, with these words.
  subroutine refuse(text, where, fragment)
    character(len=*), intent(in) :: text, where, fragment

    call refuse_file(text, place // ':' // where // ': ', fragment)
  end subroutine refuse

  !> Reads a scene that must have one problem, which starts with these words.
  subroutine refuse_file(text, start, fragment)
    character(len=*), intent(in) :: text, start
    character(len=*), intent(in), optional :: fragment
    type(scene) :: found
    type(problem_list) :: problems

    call parse_scene(place, lines(text), found, problems)
    if (present(fragment)) then
      call check(problems%count(), 1, 'problems of ' // text // ': ' // problems%text())
      call check_start(problems, start, fragment)
    else
      call check_start(problems, start, '')
    end if
  end subroutine refuse_file

  subroutine check_start(problems, start, fragment)
    type(problem_list), intent(in) :: problems
    character(len=*), intent(in) :: start, fragment
    character(len=:), allocatable :: text

    text = problems%text()
    call check(index(text, start) == 1 .and. index(text, fragment) > 0, &
               'found "' // text // '", expected "' // start // '... ' // fragment // '"')
  end subroutine check_start

  !> Compares two doubles to the last bit.
  subroutine check_number(found, expected, what)
    real(real64), intent(in) :: found, expected
    character(len=*), intent(in) :: what

    call check(found, expected, 0.0_real64, what)
  end subroutine check_number

end module asperity_scene_suite
