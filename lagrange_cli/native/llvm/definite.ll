; See definite.py. %a has %stride rows of %stride doubles, a multiple of 8, and behind them 8 doubles a row for the
; diagonal blocks. %reciprocal holds the diagonal, and becomes the 1/d_j; what is beyond %n is left out.
define internal i1 @factor_definite(ptr noalias %a, ptr noalias %reciprocal, i64 %n, i64 %stride, double %floor) #0 {
entry:
  %size = mul i64 %stride, %stride
  %factors = getelementptr inbounds double, ptr %a, i64 %size
  br label %panel
panel:
  %j = phi i64 [ 0, %entry ], [ %jn, %panel_done ]
  %regular = phi i1 [ true, %entry ], [ %fine, %panel_done ]
  %before = mul i64 %j, %stride
  %corner = add i64 %before, %j
  %rows_at = getelementptr inbounds double, ptr %a, i64 %corner
  %above = icmp ugt i64 %j, 0
  br i1 %above, label %factor, label %d.before
factor:
  %k = phi i64 [ 0, %panel ], [ %kn, %factor ]
  %krow = mul i64 %k, %stride
  %kplace = add i64 %krow, %j
  %kp = getelementptr inbounds double, ptr %a, i64 %kplace
  %u = load <8 x double>, ptr %kp, align 64
  %rp = getelementptr inbounds double, ptr %reciprocal, i64 %k
  %r = load double, ptr %rp, align 8
  %minus = fneg double %r
  %first = insertelement <8 x double> poison, double %minus, i64 0
  %minuses = shufflevector <8 x double> %first, <8 x double> poison, <8 x i32> zeroinitializer
  %f = fmul <8 x double> %u, %minuses
  %fo = mul i64 %k, 8
  %fp = getelementptr inbounds double, ptr %factors, i64 %fo
  store <8 x double> %f, ptr %fp, align 64
  %kn = add nuw nsw i64 %k, 1
  %kmore = icmp ult i64 %kn, %j
  br i1 %kmore, label %factor, label %d.before
d.before:
  %d.column = add i64 %j, 0
@@eliminate_diagonal@@
@@pivots@@
  %jn = add nuw nsw i64 %j, 8
  %jmore = icmp ult i64 %jn, %stride
  br i1 %jmore, label %c.before, label %panel_done
c.before:
  %c.column = phi i64 [ %jn, %d.done ], [ %next, %c.done ]
  %at = add i64 %before, %c.column
  %place = getelementptr inbounds double, ptr %a, i64 %at
@@eliminate@@
@@within@@
  %next = add nuw nsw i64 %c.column, 8
  %more = icmp ult i64 %next, %stride
  br i1 %more, label %c.before, label %panel_done
panel_done:
  br i1 %jmore, label %panel, label %done
done:
  call void @arrange_definite(ptr %a, ptr %reciprocal, i64 %stride)
  ret i1 %fine
}

define internal void @arrange_definite(ptr noalias %a, ptr noalias %reciprocal, i64 %stride) #0 {
entry:
  %size = mul i64 %stride, %stride
  %blocks = getelementptr inbounds double, ptr %a, i64 %size
  br label %row
row:
  %j = phi i64 [ 0, %entry ], [ %jn, %row_done ]
  %rp = getelementptr inbounds double, ptr %reciprocal, i64 %j
  %r = load double, ptr %rp, align 8
  %nr = fneg double %r
  %base = mul i64 %j, %stride
  %jp = getelementptr inbounds double, ptr %a, i64 %base
  %diagonal = getelementptr inbounds double, ptr %jp, i64 %j
  store double 0.0, ptr %diagonal, align 8
  %inside = and i64 %j, 7
  %from = and i64 %j, -8
  br label %column
column:
  %i = phi i64 [ %from, %row ], [ %in, %stored ]
  %ap = getelementptr inbounds double, ptr %jp, i64 %i
  %u = load double, ptr %ap, align 8
  %l = fmul double %u, %nr
  store double %l, ptr %ap, align 8
  %iblock = and i64 %i, -8
  %same = icmp eq i64 %iblock, %from
  br i1 %same, label %within, label %stored
within:
  %di = mul i64 %i, 8
  %dplace = add i64 %di, %inside
  %dp = getelementptr inbounds double, ptr %blocks, i64 %dplace
  store double %l, ptr %dp, align 8
  br label %stored
stored:
  %in = add i64 %i, 1
  %imore = icmp ult i64 %in, %stride
  br i1 %imore, label %column, label %row_done
row_done:
  %jn = add i64 %j, 1
  %jmore = icmp ult i64 %jn, %stride
  br i1 %jmore, label %row, label %invert
invert:
  %first = phi i64 [ 0, %row_done ], [ %first_next, %invert ]
  %rows_before = mul i64 %first, %stride
  %corner = add i64 %rows_before, %first
  %corner_at = getelementptr inbounds double, ptr %a, i64 %corner
  %kept = mul i64 %first, 8
  %block = getelementptr inbounds double, ptr %blocks, i64 %kept
@@inverse@@
  %first_next = add nuw nsw i64 %first, 8
  %inverts = icmp ult i64 %first_next, %stride
  br i1 %inverts, label %invert, label %above
above:
  %k = phi i64 [ 0, %invert ], [ %kn, %above_done ]
  %kbefore = mul i64 %k, %stride
  %kcorner = add i64 %kbefore, %k
  %of_rows = getelementptr inbounds double, ptr %a, i64 %kcorner
  %kn = add nuw nsw i64 %k, 8
  %kmore = icmp ult i64 %kn, %stride
  br i1 %kmore, label %beside, label %done
beside:
  %c = phi i64 [ %kn, %above ], [ %cn, %beside ]
  %uplace = add i64 %kbefore, %c
  %upper = getelementptr inbounds double, ptr %a, i64 %uplace
@@scale@@
  %cn = add nuw nsw i64 %c, 8
  %cmore = icmp ult i64 %cn, %stride
  br i1 %cmore, label %beside, label %above_done
above_done:
  br label %above
done:
  ret void
}
